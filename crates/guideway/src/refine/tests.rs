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
