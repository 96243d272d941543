//! Reads the binary grey images of the `map_server` maps from `GUIDEWAY_DATA` or `../shared/data` beside the workspace; cells that are not surely free
//! are blocked.

use guideway::world::{Bits, Grid, World};
use std::path::{Path, PathBuf};

/// Paths of all YAML files whose image is a binary grey PGM, sorted; empty (and a printed line) if there is no data.
pub fn files() -> Vec<PathBuf> {
    let root = std::env::var_os("GUIDEWAY_DATA")
        .map_or_else(|| Path::new(env!("CARGO_MANIFEST_DIR")).join("../../../shared/data"), PathBuf::from)
        .join("ros_maps");
    let (mut found, mut todo) = (Vec::new(), vec![root]);
    while let Some(folder) = todo.pop() {
        for entry in std::fs::read_dir(folder).into_iter().flatten().flatten() {
            let path = entry.path();
            if path.is_dir() {
                todo.push(path);
            } else if path.extension().is_some_and(|e| e == "yaml") {
                found.push(path);
            }
        }
    }
    found.sort();
    if found.is_empty() {
        println!("skipped: no map_server data (set GUIDEWAY_DATA)");
    }
    found
}

/// A map, if its image is a binary grey PGM.
pub fn load(yaml: &Path) -> Option<World> {
    let text = std::fs::read_to_string(yaml).ok()?;
    let field = |key: &str| text.lines().find_map(|l| l.strip_prefix(key)?.strip_prefix(':').map(str::trim));
    let number = |s: &str| s.trim().parse::<f64>().ok();
    let resolution = number(field("resolution")?)?;
    let origin: Vec<f64> = field("origin")?.trim_matches(['[', ']']).split(',').filter_map(number).collect();
    let free_below = number(field("free_thresh")?)?;
    let negate = field("negate").is_some_and(|n| n == "1");
    let image = std::fs::read(yaml.parent()?.join(field("image")?)).ok()?;
    let (w, h, first) = header(&image)?;
    let mut blocked = Bits::new(w, h);
    for y in 0..h {
        for x in 0..w {
            let v = f64::from(*image.get(first + y as usize * w as usize + x as usize)?);
            let p = if negate { v / 255.0 } else { (255.0 - v) / 255.0 };
            blocked.set(x, h - 1 - y, p >= free_below);
        }
    }
    Some(World::from_grid(Grid::new(blocked, None, resolution, origin.try_into().ok()?).ok()?))
}

/// Width, height and offset of the first pixel of a binary grey image with 8 bits.
fn header(image: &[u8]) -> Option<(u32, u32, usize)> {
    let (mut at, mut values) = (2, Vec::new());
    if image.get(..2)? != b"P5" {
        return None;
    }
    while values.len() < 3 {
        match *image.get(at)? {
            b'#' => at += image[at..].iter().position(|&c| c == b'\n')?,
            c if c.is_ascii_digit() => {
                let end = at + image[at..].iter().position(|c| !c.is_ascii_digit())?;
                values.push(std::str::from_utf8(&image[at..end]).ok()?.parse().ok()?);
                at = end;
            }
            _ => at += 1,
        }
    }
    (values[2] == 255).then_some((values[0], values[1], at + 1))
}
