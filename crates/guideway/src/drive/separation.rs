//! The judge: exact distances of the true footprint to everything, between samples as well.

use super::Outline;
use super::arc;
use super::sense::Stage;
use crate::Point;
use crate::world::shape::wrap;
use crate::world::{Footprint, Shape, World};

/// Times closer than this are one moment, s: a refinement stops here.
const MOMENT: f64 = 1e-7;
/// The smallest distances of a run are known to this, m.
const FINE: f64 = 1e-4;
/// Overlap below this is contact by rounding, m.
const CONTACT: f64 = -1e-9;
/// How far the reference point may be outside the border before it counts as a collision, m.
const BORDER: f64 = 0.05;

/// The robot's motion over one sub-step: constant speed and turn rate from `pose`.
#[derive(Debug, Clone, Copy)]
pub(super) struct Leg {
    pub t: f64,
    pub duration: f64,
    pub pose: [f64; 3],
    pub v: f64,
    pub w: f64,
}

impl Leg {
    /// The arc that starts and ends like the plant did.
    pub fn between(t: f64, duration: f64, from: [f64; 3], to: [f64; 3]) -> Self {
        let turn = wrap(to[2] - from[2]);
        let chord = (to[0] - from[0]).hypot(to[1] - from[1]);
        let half = 0.5 * turn;
        let along = (to[0] - from[0]) * (from[2] + half).cos() + (to[1] - from[1]) * (from[2] + half).sin();
        let bend = if half.abs() < 1e-9 { 1.0 } else { half / half.sin() };
        Self { t, duration, pose: from, v: chord.copysign(along) * bend / duration, w: turn / duration }
    }
    fn at(&self, t: f64) -> [f64; 3] {
        arc(self.pose, self.v, self.w, t - self.t)
    }
}

/// What the robot ran into.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum With {
    Static,
    Border,
    Mover(usize),
}

/// Watches one robot for a whole run.
pub(super) struct Judge<'a> {
    world: &'a World,
    outline: Outline,
    reach: f64,
    inscribed: f64,
    /// Smallest distance to static obstacles so far, m.
    pub still: f64,
    /// Smallest distance to movers so far, m.
    pub moving: f64,
    /// Time spent in forbidden places so far, s; `None` where nothing is forbidden.
    pub forbidden: Option<f64>,
}

impl<'a> Judge<'a> {
    pub fn new(world: &'a World, footprint: &Footprint) -> Self {
        let outline = Outline::of(footprint);
        let reach = outline.circumscribed();
        let forbidden = world.forbidden().map(|places| {
            // Queries use these where they are there.
            places.clearance_field();
            world.solid().clearance_field();
            0.0
        });
        Self { world, outline, reach, inscribed: footprint.inscribed(), still: f64::INFINITY, moving: f64::INFINITY, forbidden }
    }

    /// The first contact during a leg, if any: what and when (s). Keeps the smallest distances up to then.
    pub fn watch(&mut self, leg: &Leg, stage: &Stage) -> Option<(With, f64)> {
        let end = leg.t + leg.duration;
        let own = leg.v.abs() + leg.w.abs() * self.reach;
        self.trespass(leg);
        let mut first = self.border(leg).map(|t| (With::Border, t));
        let mut still = self.still;
        let gap = |t: f64, best: f64| static_gap(self.world.solid(), &self.outline, [self.reach, self.inscribed], (leg.at(t), best));
        let hit = descend(&gap, own, [leg.t, end], &mut still);
        self.still = still;
        first = earlier(first, hit.map(|t| (With::Static, t)));
        for (i, mover, outline) in stage.present() {
            let mut moving = self.moving;
            let gap = |t: f64, _: f64| {
                let (p, _) = mover.at(t);
                let [x, y, yaw] = leg.at(t);
                self.outline.at([x - p[0], y - p[1], yaw]).gap(outline)
            };
            let hit = descend(&gap, own + mover.top_speed(), [leg.t, end], &mut moving);
            self.moving = moving;
            first = earlier(first, hit.map(|t| (With::Mover(i), t)));
        }
        first
    }

    /// Counts a leg that ends in a forbidden place. It is no collision: nothing stands there.
    fn trespass(&mut self, leg: &Leg) {
        if let (Some(total), Some(world)) = (&mut self.forbidden, self.world.forbidden())
            && static_gap(world, &self.outline, [self.reach, self.inscribed], (leg.at(leg.t + leg.duration), 0.0)) < CONTACT
        {
            *total += leg.duration;
        }
    }

    fn border(&self, leg: &Leg) -> Option<f64> {
        let end = leg.at(leg.t + leg.duration);
        let near = |dx: f64| [0.0, BORDER, -BORDER].into_iter().any(|dy| self.world.contains([end[0] + dx, end[1] + dy]));
        let inside = [0.0, BORDER, -BORDER].into_iter().any(near);
        (!inside).then_some(leg.t + leg.duration)
    }
}

fn earlier(a: Option<(With, f64)>, b: Option<(With, f64)>) -> Option<(With, f64)> {
    match (a, b) {
        (Some(p), Some(q)) => Some(if q.1 < p.1 { q } else { p }),
        (p, q) => p.or(q),
    }
}

/// First time in `span` at which `gap` is below contact, given that it changes by at most `speed` per second; lowers `best` to the smallest gap
/// (within [`FINE`]) up to then. `gap(t, cap)` may return any value >= `cap` when the true one is >= `cap`.
fn descend(gap: &dyn Fn(f64, f64) -> f64, speed: f64, span: [f64; 2], best: &mut f64) -> Option<f64> {
    let cap = |best: f64| best.max(0.0) + speed * (span[1] - span[0]);
    let ends = span.map(|t| gap(t, cap(*best)));
    if ends[0] < CONTACT {
        *best = best.min(ends[0]);
        return Some(span[0]);
    }
    *best = best.min(ends[0]);
    search(gap, speed, [(span[0], ends[0]), (span[1], ends[1])], best)
}

fn search(gap: &dyn Fn(f64, f64) -> f64, speed: f64, [a, b]: [(f64, f64); 2], best: &mut f64) -> Option<f64> {
    let least = 0.5 * (a.1 + b.1 - speed * (b.0 - a.0));
    let settled = least >= CONTACT && least >= best.min(b.1) - FINE;
    if settled || b.0 - a.0 < MOMENT {
        *best = best.min(b.1);
        return (b.1 < CONTACT).then_some(b.0);
    }
    let t = 0.5 * (a.0 + b.0);
    let middle = (t, gap(t, best.max(0.0) + speed * (b.0 - a.0)));
    if middle.1 < CONTACT {
        return search(gap, speed, [a, middle], best);
    }
    *best = best.min(middle.1);
    search(gap, speed, [a, middle], best).or_else(|| search(gap, speed, [middle, b], best))
}

/// Distance of an outline at a pose to the static world, m. Values of at least `cap` may be returned smaller than they are, but not below `cap`.
fn static_gap(world: &World, outline: &Outline, [reach, inscribed]: [f64; 2], (pose, cap): ([f64; 3], f64)) -> f64 {
    let center = world.clearance([pose[0], pose[1]]);
    if outline.points.len() == 1 || center - reach >= cap || center.is_infinite() {
        return center - reach;
    }
    let here = outline.at(pose);
    let shapes = world.shapes().iter().map(|s| here.gap(&of_shape(s))).fold(f64::INFINITY, f64::min);
    shapes.min(grid_gap(world, &here, (center - inscribed).min(shapes).max(0.0)))
}

fn of_shape(shape: &Shape) -> Outline {
    match shape {
        Shape::Disc { center, radius } => Outline { points: vec![*center], radius: *radius },
        Shape::Polygon { points } => Outline { points: points.clone(), radius: 0.0 },
    }
}

/// Exact distance to the blocked cells, m, if it is below `cap`.
fn grid_gap(world: &World, here: &Outline, cap: f64) -> f64 {
    let Some(grid) = world.grid() else { return f64::INFINITY };
    let corners: Vec<Point> = here.points.iter().map(|p| grid.to_cells(*p)).collect();
    let side = grid.resolution();
    let pad = (cap + here.radius) / side + 1e-9;
    let range = |k: usize, top: u32| {
        let low = corners.iter().map(|p| p[k]).fold(f64::INFINITY, f64::min) - pad;
        let high = corners.iter().map(|p| p[k]).fold(f64::NEG_INFINITY, f64::max) + pad;
        (low.floor().clamp(0.0, f64::from(top)) as u32, high.ceil().clamp(0.0, f64::from(top)) as u32)
    };
    let ((x0, x1), (y0, y1)) = (range(0, grid.width()), range(1, grid.height()));
    let robot = Outline { points: corners, radius: here.radius / side };
    let mut best = f64::INFINITY;
    for y in y0..y1 {
        for x in (x0..x1).filter(|x| grid.blocked().at(*x, y)) {
            let (i, j) = (f64::from(x), f64::from(y));
            let cell = Outline { points: vec![[i, j], [i + 1.0, j], [i + 1.0, j + 1.0], [i, j + 1.0]], radius: 0.0 };
            best = best.min(robot.gap(&cell));
        }
    }
    if best.is_finite() { best * side } else { cap }
}

#[cfg(test)]
mod tests;
