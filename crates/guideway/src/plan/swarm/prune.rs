//! Any-angle paths from lattice paths: way points that can be passed by in a straight line are dropped.

use crate::plan::legs::Leg;
use crate::world::Cell;

/// From each way point, the farthest cell of the path that the robot can go to straight.
pub(super) fn pull(leg: &Leg, cells: &[Cell]) -> Vec<Cell> {
    let free = |a: usize, b: usize| leg.query.world.segment_free(leg.lattice.center(cells[a]), leg.lattice.center(cells[b]), leg.query.radius());
    let last = cells.len() - 1;
    let (mut at, mut points) = (0, vec![cells[0]]);
    while at < last {
        at = (at + 2..=last).rev().find(|&to| free(at, to)).unwrap_or(at + 1);
        points.push(cells[at]);
    }
    points
}

/// Length of a way through cell centres, cells.
pub(super) fn length(points: &[Cell]) -> f64 {
    let span = |p: &[Cell]| (f64::from(p[1][0]) - f64::from(p[0][0])).hypot(f64::from(p[1][1]) - f64::from(p[0][1]));
    points.windows(2).map(span).sum()
}
