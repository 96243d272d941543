use super::*;
use crate::world::{Bits, Grid, World};
use std::sync::Arc;

fn grid(rows: &[&str]) -> World {
    let (w, h) = (rows[0].len() as u32, rows.len() as u32);
    let mut blocked = Bits::new(w, h);
    for (y, row) in rows.iter().rev().enumerate() {
        for (x, c) in row.bytes().enumerate() {
            blocked.set(x as u32, y as u32, c == b'#');
        }
    }
    World::from_grid(Grid::new(blocked, None, 1.0, [0.0; 3]).unwrap())
}

#[test]
fn taut_corner() {
    let world = grid(&["..........", "..........", "....##....", "....##....", "....##....", "....##...."]);
    let query = Query::new(Arc::new(world), [1.0, 0.5], [9.0, 0.5]);
    let raw = Path::polyline(&[[1.0, 0.5], [4.0, 4.0], [6.0, 4.0], [9.0, 0.5]]);
    let mut ctx = Context::new(0);
    let refined = Smooth::default().refine(&raw, &query, &mut ctx).unwrap();
    println!("{} -> {} unmet {:?}", raw.length(), refined.path.length(), refined.unmet);
    for i in 0..=40 {
        let s = refined.path.length() * f64::from(i) / 40.0;
        let p = refined.path.planar(s);
        println!("{:.3} ({:.3}, {:.3}) {:.3} {:.3} c {:.4}", s, p.point[0], p.point[1], p.heading, p.curvature, query.world.clearance(p.point));
    }
}

#[test]
fn jagged_corner() {
    let mut blocked = Bits::new(120, 120);
    // A block with a jagged upper right corner.
    for y in 0..76 {
        for x in 30..64 {
            let cut = (x >= 62 && y >= 75) || (x >= 63 && y < 66);
            blocked.set(x, y, !cut);
        }
    }
    let world = World::from_grid(Grid::new(blocked, None, 0.03, [0.0; 3]).unwrap());
    let cells = |x: f64, y: f64| [x * 0.03, y * 0.03];
    let query = Query::new(Arc::new(world), cells(2.0, 90.0), cells(40.0, 2.0));
    let raw = Path::polyline(&[cells(2.0, 90.0), cells(62.0, 76.0), cells(64.0, 75.0), cells(64.0, 66.0), cells(63.0, 10.0), cells(63.0, 2.0)]);
    let refined = Smooth::default().refine(&raw, &query, &mut Context::new(0)).unwrap();
    println!("{} -> {} unmet {:?}", raw.length(), refined.path.length(), refined.unmet);
    for i in 0..=60 {
        let s = refined.path.length() * f64::from(i) / 60.0;
        let p = refined.path.planar(s);
        println!(
            "{:.3} ({:.3}, {:.3}) {:.3} {:.3} c {:.4}",
            s,
            p.point[0] / 0.03,
            p.point[1] / 0.03,
            p.heading,
            p.curvature,
            query.world.clearance(p.point)
        );
    }
}
