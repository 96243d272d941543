//! What is free around the robot now and in the next seconds: the static map and movers at constant velocity.

use super::{Observation, Robot, Track, arc};
use crate::Point;
use crate::world::World;

/// Clearances are looked up to this far beyond what the robot needs, m.
const REACH: f64 = 0.8;
/// How far the reference point may be estimated outside the border, m.
const BORDER: f64 = 0.03;
/// Left of the room there is when the robot already stands nearer than its margin, m.
const SPARE: f64 = 0.005;
/// Shortest step of a contact search, s.
const LEAST: f64 = 0.01;

/// Margins around the robot.
#[derive(Debug, Clone, Copy)]
pub(super) struct Margins {
    /// To static obstacles, m.
    pub still: f64,
    /// To movers, m.
    pub moving: f64,
    /// Growth of the margin to movers with the time predicted, m/s.
    pub growth: f64,
}

/// A mover near enough to matter, with the distance that counts as contact.
struct Near<'a> {
    track: &'a Track,
    speed: f64,
    keep: f64,
    growth: f64,
}

/// What was met first.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) enum Met {
    Static,
    Mover(usize),
}

/// The surroundings of one control step.
pub(super) struct Field<'a> {
    world: &'a World,
    keep: f64,
    near: Vec<Near<'a>>,
}

impl<'a> Field<'a> {
    /// The robot is the disc that covers its footprint. Margins shrink to the room there is at the start, so that a robot that stands too near may leave
    /// but not come nearer. Movers that cannot be met within `horizon` s are left out.
    pub fn new(world: &'a World, robot: &Robot, seen: &'a Observation, margins: Margins, horizon: f64) -> Self {
        let radius = robot.footprint.circumscribed();
        let p = [seen.pose[0], seen.pose[1]];
        let room = world.clearance_within(p, radius + margins.still + 0.1) - radius;
        let keep = radius + margins.still.min(room - SPARE).max(0.0);
        let near = seen.tracks.iter().filter_map(|track| {
            let speed = track.velocity[0].hypot(track.velocity[1]);
            let gap = track.distance(p, 0.0) - radius;
            let far = (robot.speed + speed + margins.growth) * horizon + margins.moving;
            (gap < far).then(|| Near { track, speed, keep: radius + margins.moving.min(gap - 0.01).max(0.01), growth: margins.growth })
        });
        Self { world, keep, near: near.collect() }
    }

    /// Distance that the robot at `p` can move in any direction without meeting a static obstacle, m; not positive where it may not be.
    #[inline]
    pub fn slack(&self, p: Point) -> f64 {
        let border = self.border(p);
        if border <= 0.0 {
            return border;
        }
        border.min(self.world.clearance_within(p, self.keep + REACH).min(self.keep + REACH) - self.keep)
    }

    /// Distance of the reference point to the border and a little beyond, m.
    fn border(&self, p: Point) -> f64 {
        let (q, low, high, scale) = if let Some(grid) = self.world.grid() {
            (grid.to_cells(p), [0.0; 2], [f64::from(grid.width()), f64::from(grid.height())], grid.resolution())
        } else {
            let [x0, y0, x1, y1] = self.world.bounds();
            (p, [x0, y0], [x1, y1], 1.0)
        };
        (0..2).map(|k| (q[k] - low[k]).min(high[k] - q[k])).fold(f64::INFINITY, f64::min) * scale + BORDER
    }

    /// Smallest room to a mover at `p` after `t` s, m, its index in the observation, and how long a robot at speed `v` cannot meet any, s.
    #[inline]
    pub fn movers(&self, p: Point, t: f64, v: f64) -> (f64, usize, f64) {
        let mut least = (f64::INFINITY, usize::MAX, f64::INFINITY);
        for near in &self.near {
            let gap = near.track.distance(p, t) - near.keep - near.growth * t;
            least.2 = least.2.min(gap / (v + near.speed + near.growth).max(1e-6));
            if gap < least.0 {
                (least.0, least.1) = (gap, near.track.id);
            }
        }
        least
    }

    /// Room at `p` after `t` s to all places that movers could have reached by then at their present speeds in any direction, m.
    pub fn doubt(&self, p: Point, t: f64) -> f64 {
        self.near.iter().map(|near| near.track.distance(p, 0.0) - near.keep - near.speed * t).fold(f64::INFINITY, f64::min)
    }

    /// First contact on the arc of constant `v` (>= 0 m/s) and `w` (rad/s) within `horizon` s: when and with what. Conservative advancement: a step
    /// is never longer than the free distance over the closing speed, or 0.01 s.
    pub fn contact(&self, pose: [f64; 3], v: f64, w: f64, horizon: f64) -> Option<(f64, Met)> {
        let (mut t, mut checked) = (0.0, 0.0);
        while t <= horizon {
            let at = arc(pose, v, w, t);
            let p = [at[0], at[1]];
            if t >= checked && (v > 0.0 || t == 0.0) {
                let slack = self.slack(p);
                if slack <= 0.0 {
                    return Some((t, Met::Static));
                }
                checked = if v > 0.0 { t + slack / v } else { f64::INFINITY };
            }
            let (gap, id, safe) = self.movers(p, t, v);
            if gap <= 0.0 {
                return Some((t, Met::Mover(id)));
            }
            t += (checked - t).min(safe).max(LEAST);
        }
        None
    }
}
