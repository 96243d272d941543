//! Reads the Moving AI benchmark (gzip-compressed maps and scenarios) from `GUIDEWAY_DATA` or `../shared/data` beside the workspace.

use flate2::read::GzDecoder;
use guideway::world::{Bits, Cell, Grid, World};
use std::io::Read;
use std::path::{Path, PathBuf};

/// One row of a scenario file; rows of the file count from the top, cells from the bottom.
pub struct Row {
    pub start: Cell,
    pub goal: Cell,
    pub optimum: f64,
}

/// The folder with `maps` and `scen`; `None` (and a printed line) if there is no data.
pub fn folder() -> Option<PathBuf> {
    let root = std::env::var_os("GUIDEWAY_DATA")
        .map_or_else(|| Path::new(env!("CARGO_MANIFEST_DIR")).join("../../../shared/data"), PathBuf::from)
        .join("moving_ai");
    if root.is_dir() {
        return Some(root);
    }
    println!("skipped: no Moving AI data (set GUIDEWAY_DATA)");
    None
}

/// Names like `dao/den312d`, sorted.
pub fn names(root: &Path) -> Vec<String> {
    let list = |p: &Path| std::fs::read_dir(p).unwrap().map(|e| e.unwrap().file_name().into_string().unwrap()).collect::<Vec<_>>();
    let mut names = Vec::new();
    for set in list(&root.join("maps")) {
        names.extend(list(&root.join("maps").join(&set)).iter().filter_map(|n| n.strip_suffix(".map.gz")).map(|n| format!("{set}/{n}")));
    }
    names.sort();
    names
}

fn text(path: &Path) -> String {
    let mut out = String::new();
    GzDecoder::new(std::fs::File::open(path).unwrap()).read_to_string(&mut out).unwrap();
    out
}

/// Map and scenario.
pub fn load(root: &Path, name: &str) -> (World, Vec<Row>) {
    let map = text(&root.join(format!("maps/{name}.map.gz")));
    let (head, body) = map.split_once("\nmap").unwrap();
    let size = |key: &str| head.lines().find_map(|l| l.strip_prefix(key)).unwrap().trim().parse::<u32>().unwrap();
    let (w, h) = (size("width"), size("height"));
    let mut blocked = Bits::new(w, h);
    for (y, line) in body.trim_start().lines().enumerate() {
        for (x, c) in line.trim_end().bytes().enumerate() {
            blocked.set(x as u32, h - 1 - y as u32, !matches!(c, b'.' | b'G' | b'S'));
        }
    }
    let rows = text(&root.join(format!("scen/{name}.map.scen.gz")))
        .lines()
        .skip(1)
        .filter(|l| !l.trim().is_empty())
        .map(|line| {
            let f: Vec<&str> = line.split_whitespace().collect();
            let n = |k: usize| f[k].parse::<u32>().unwrap();
            Row { start: [n(4), h - 1 - n(5)], goal: [n(6), h - 1 - n(7)], optimum: f[8].trim().parse().unwrap() }
        })
        .inspect(|row| assert!(row.optimum.is_finite(), "{name}"))
        .collect();
    (World::from_grid(Grid::new(blocked, None, 1.0, [0.0; 3]).unwrap()), rows)
}
