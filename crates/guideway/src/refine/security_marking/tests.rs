use super::*;
use crate::path::measure;
use crate::world::{Bits, Corners, Grid, World};
use proptest::prelude::*;
use std::sync::Arc;

fn query(rows: &[&str], corners: Corners) -> Query {
    let (w, h) = (rows[0].len() as u32, rows.len() as u32);
    let mut blocked = Bits::new(w, h);
    for (y, row) in rows.iter().rev().enumerate() {
        for (x, c) in row.bytes().enumerate() {
            blocked.set(x as u32, y as u32, c == b'#');
        }
    }
    let world = Arc::new(World::from_grid(Grid::new(blocked, None, 1.0, [0.0; 3]).unwrap()));
    let mut query = Query::new(world, [0.5, 0.5], [f64::from(w) - 0.5, 0.5]);
    (query.corners, query.material) = (corners, crate::query::Material::Long);
    query
}

fn tidied(query: &Query, points: &[Point]) -> Vec<Point> {
    SecurityMarking {}.refine(&Path::polyline(points), query, &mut Context::new(0)).unwrap().path.points()
}

fn at(cells: &[[u32; 2]]) -> Vec<Point> {
    cells.iter().map(|c| c.map(|v| f64::from(v) + 0.5)).collect()
}

#[test]
fn loops_are_cut_and_stairs_become_diagonals() {
    let query = query(&["....", "....", "...."], Corners::Clear);
    let stairs = at(&[[0, 0], [0, 1], [1, 1], [1, 2], [2, 2], [2, 1], [1, 1], [2, 1], [2, 0], [3, 0]]);
    assert_eq!(tidied(&query, &stairs), at(&[[0, 0], [1, 1], [2, 0], [3, 0]]));
}

#[test]
fn a_diagonal_at_a_blocked_cell_is_no_step_of_the_marking() {
    let rows = ["....", ".#..", "...."];
    let around = at(&[[0, 0], [1, 0], [2, 0], [2, 1], [2, 2], [1, 2], [0, 2], [0, 1], [0, 2], [1, 2], [2, 2], [2, 1], [2, 0], [3, 0]]);
    assert_eq!(tidied(&query(&rows, Corners::Clear), &around), at(&[[0, 0], [3, 0]]));
    let over = at(&[[0, 0], [0, 1], [0, 2], [1, 2], [2, 2], [2, 1], [3, 1], [3, 0]]);
    assert_eq!(tidied(&query(&rows, Corners::Clear), &over), at(&[[0, 0], [0, 2], [2, 2], [3, 1], [3, 0]]));
    assert_eq!(tidied(&query(&rows, Corners::Touch), &over), at(&[[0, 0], [0, 1], [1, 2], [3, 0]]));
}

#[test]
fn stops_beside_the_centres_and_via_points_stay() {
    let mut query = query(&["....", "....", "...."], Corners::Clear);
    (query.start, query.goal, query.via) = ([0.6, 0.6], [3.3, 0.4], vec![[1.5, 2.5], [2.7, 1.6]]);
    let mut points = vec![query.start];
    points.extend(at(&[[0, 0], [0, 1], [0, 2], [1, 2], [2, 2], [2, 1]]));
    points.push(query.via[1]);
    points.extend(at(&[[2, 1], [2, 0], [3, 0]]));
    points.push(query.goal);
    let mut expected = vec![query.start];
    expected.extend(at(&[[0, 0], [0, 1], [1, 2], [2, 1]]));
    expected.push(query.via[1]);
    expected.extend(at(&[[2, 1], [3, 0]]));
    expected.push(query.goal);
    assert_eq!(tidied(&query, &points), expected);
}

#[test]
fn other_paths_are_left_to_lines_of_sight() {
    let mut query = query(&["....", "....", "...."], Corners::Touch);
    query.goal = [3.5, 2.0];
    assert_eq!(tidied(&query, &[[0.5, 0.5], [1.3, 2.2], [3.5, 2.0]]), [[0.5, 0.5], [3.5, 2.0]]);
}

proptest! {
    #![proptest_config(ProptestConfig { rng_seed: proptest::test_runner::RngSeed::Fixed(7), ..ProptestConfig::default() })]

    /// Random walks: the result is legal, clear by half a cell, no longer, and nothing is left to merge.
    #[test]
    fn random_walks_become_tidy(holes in proptest::collection::vec(any::<bool>(), 64), steps in proptest::collection::vec(0usize..8, 1..120)) {
        const WAYS: [[i64; 2]; 8] = [[1, 0], [1, 1], [0, 1], [-1, 1], [-1, 0], [-1, -1], [0, -1], [1, -1]];
        let rows: Vec<String> = (0..8).map(|y| (0..8).map(|x| if holes[8 * y + x] && [x, y] != [0, 7] && (x * y) % 3 > 0 { '#' } else { '.' }).collect()).collect();
        let mut query = query(&rows.iter().map(String::as_str).collect::<Vec<_>>(), Corners::Clear);
        let lattice = query.world.lattice(0.0);
        let mut cells = vec![[0u32, 0]];
        for way in steps {
            let (from, [dx, dy]) = (cells[cells.len() - 1], WAYS[way]);
            if lattice.step_free(from, dx, dy, Corners::Clear) {
                cells.push([(i64::from(from[0]) + dx) as u32, (i64::from(from[1]) + dy) as u32]);
            }
        }
        let walk = at(&cells);
        query.goal = walk[walk.len() - 1];
        let before = Path::polyline(&walk);
        let path = SecurityMarking {}.refine(&before, &query, &mut Context::new(0)).unwrap().path;
        prop_assert!(path.length() <= before.length() + 1e-9);
        prop_assert_eq!(path.ends(), [query.start, query.goal]);
        prop_assert!(path.length() == 0.0 || measure(&path, &query.world, 0.0).min_clearance.is_none_or(|c| c >= 0.5 - 1e-9));
        let again = SecurityMarking {}.refine(&path, &query, &mut Context::new(0)).unwrap().path;
        prop_assert_eq!(again.points(), path.points());
        let found = stations(&path, &query, &lattice).unwrap();
        prop_assert!(path.length() == 0.0 || found.windows(2).all(|w| w[0].cell.is_some() && w[1].cell.is_some()));
    }
}
