//! What is free around the robot now and in the next seconds: the static world, movers at constant velocity, and all that movers could reach.

use super::body::Body;
use super::crowd::{Around, Crowd, Near};
use super::rooms::Rooms;
use super::{Observation, Robot, Track, arc};
use crate::Point;
use crate::world::shape::{convex_distance, distance};
use crate::world::{Shape, World};

/// Clearances are looked up to this far beyond what the robot needs, m.
const REACH: f64 = 0.8;
/// How far the reference point may be estimated outside the border, m.
const BORDER: f64 = 0.03;
/// Left of the room there is when the robot already stands nearer than its margin, m.
const SPARE: f64 = 0.005;
/// Movers that are slower than this at most have margins that grow less, m/s.
const SLOW: f64 = 0.3;
/// A shortcut leaves so much more room than what it stands for, m: rounding is far below.
const SURE: f64 = 1e-6;
/// Shortest step of a contact search, s.
const LEAST: f64 = 0.01;

/// Margins around the robot in predictions.
#[derive(Debug, Clone, Copy)]
pub(super) struct Margins {
    /// To static obstacles, m.
    pub still: f64,
    /// To movers, m.
    pub moving: f64,
    /// Growth of the margin to movers with the time predicted, m/s.
    pub growth: f64,
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
    body: &'a Body,
    /// Shapes within reach.
    shapes: Vec<&'a Shape>,
    gridded: bool,
    keep: f64,
    crowd: Crowd<'a>,
    rooms: Option<&'a Rooms>,
}

impl<'a> Field<'a> {
    /// Margins shrink to the room there is at the start, so that a robot that stands too near may leave but not come nearer. Movers and shapes that
    /// cannot be met within `horizon` s are left out.
    pub fn new(world: &'a World, robot: &Robot, body: &'a Body, seen: &'a Observation, (margins, horizon): (Margins, f64)) -> Self {
        let p = [seen.pose[0], seen.pose[1]];
        let far = robot.speed * horizon + body.reach + margins.still + REACH;
        let shapes = world.shapes().iter().filter(|s| s.distance(p) < far).collect();
        let mut field = Self { world, body, shapes, gridded: world.grid().is_some(), keep: 0.0, crowd: Crowd::new(Vec::new()), rooms: None };
        let room = field.slack(seen.pose);
        field.keep = margins.still.min(room - SPARE).max(0.0);
        let near = seen.tracks.iter().filter_map(|track| {
            let (speed, radius) = (track.velocity[0].hypot(track.velocity[1]), track.outline.circumscribed());
            let away = distance(p, track.position) - radius - body.reach;
            let far = (robot.speed + speed.max(track.bound) + margins.growth) * horizon + margins.moving + track.doubt;
            if away.is_nan() || away >= far {
                return None;
            }
            // What cannot move needs no growing margin.
            let lively = (track.bound / SLOW).min(1.0);
            let mut near = Near { track, radius, speed, keep: 0.0, growth: margins.growth * lively, lively };
            let gap = discs(body, seen.pose).map(|(c, r)| near.distance(c, 0.0) - r).fold(f64::INFINITY, f64::min);
            near.keep = (margins.moving + track.doubt).min(gap - 0.01).max(0.01);
            Some(near)
        });
        field.crowd = Crowd::new(near.collect());
        field
    }

    /// With lower bounds of the clearance in the same world.
    pub fn with_rooms(mut self, rooms: &'a Rooms) -> Self {
        self.rooms = Some(rooms);
        self
    }

    /// Clearance of a point to the static world, m, exact below `reach`.
    fn clear(&self, p: Point, reach: f64) -> f64 {
        if self.gridded {
            return self.world.clearance_within(p, reach);
        }
        self.shapes.iter().fold(f64::INFINITY, |least, s| if surely_beyond(s, p, least) { least } else { least.min(s.distance(p)) })
    }

    /// Distance that the robot at `pose` can move in any direction without meeting a static obstacle (its discs, with their margin), m; not positive
    /// where it may not be.
    #[inline]
    pub fn slack(&self, pose: [f64; 3]) -> f64 {
        let border = self.border([pose[0], pose[1]]);
        if border <= 0.0 {
            return border;
        }
        let discs = discs(self.body, pose).map(|(c, r)| {
            let cap = r + self.keep + REACH;
            self.clear(c, cap).min(cap) - r - self.keep
        });
        discs.fold(border, f64::min)
    }

    /// As [`Field::slack`], or less where it is certainly positive.
    #[inline]
    pub fn free(&self, pose: [f64; 3]) -> f64 {
        let Some(rooms) = self.rooms else { return self.slack(pose) };
        let mut free = self.border([pose[0], pose[1]]);
        for (c, r) in discs(self.body, pose) {
            match rooms.at(c).map(|room| room - r - self.keep) {
                Some(room) if room > 0.0 => free = free.min(room),
                _ => return self.slack(pose),
            }
        }
        free
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

    /// Distance of the exact footprint at `pose` to static obstacles and of the reference point to the border, m. Where it is at least `cap`, anything
    /// from `cap` up that is not more than it.
    pub fn gap(&self, pose: [f64; 3], cap: f64) -> f64 {
        let p = [pose[0], pose[1]];
        let border = self.border(p);
        let middle = self.clear(p, cap + self.body.reach).min(cap + self.body.reach);
        if self.body.round() || middle - self.body.reach >= cap || middle <= self.body.inscribed {
            return border.min(middle - if middle <= self.body.inscribed { self.body.inscribed } else { self.body.reach });
        }
        let here = self.body.outline.at(pose);
        let shapes = self.shapes.iter().map(|s| s.body_distance(&here.points)).fold(cap, f64::min);
        border.min(shapes).min(self.cells(&here.points, shapes))
    }

    /// Distance of a convex body to the blocked cells, m, exact below `cap`, else `cap`.
    fn cells(&self, corners: &[Point], cap: f64) -> f64 {
        let Some(grid) = self.world.grid() else { return cap };
        let side = grid.resolution();
        let corners: Vec<Point> = corners.iter().map(|p| grid.to_cells(*p)).collect();
        let pad = cap.max(0.0) / side + 1e-9;
        let range = |k: usize, top: u32| {
            let low = corners.iter().map(|p| p[k]).fold(f64::INFINITY, f64::min) - pad;
            let high = corners.iter().map(|p| p[k]).fold(f64::NEG_INFINITY, f64::max) + pad;
            low.floor().clamp(0.0, f64::from(top)) as u32..high.ceil().clamp(0.0, f64::from(top)) as u32
        };
        let mut best = cap / side;
        for y in range(1, grid.height()) {
            for x in range(0, grid.width()).filter(|x| grid.blocked().at(*x, y)) {
                let (i, j) = (f64::from(x), f64::from(y));
                best = best.min(convex_distance(&corners, &[[i, j], [i + 1.0, j], [i + 1.0, j + 1.0], [i, j + 1.0]]));
            }
        }
        best * side
    }

    /// Movers at constant velocity around `pose` after `t` s, for a robot whose points move at most at `v` m/s.
    #[inline]
    pub fn movers(&self, pose: [f64; 3], t: f64, v: f64) -> Around {
        self.movers_of(&self.crowd, pose, (t, 0.0), v)
    }

    /// As [`Field::movers`] with a part of them, for which rooms have become less by at most `spent` m.
    #[inline]
    pub fn movers_of(&self, part: &Crowd<'a>, pose: [f64; 3], (t, spent): (f64, f64), v: f64) -> Around {
        part.around(discs(self.body, pose), (t, spent), v)
    }

    /// The number of the mover that leaves the robot at `pose` the least room after `t` s.
    pub fn first(&self, pose: [f64; 3], t: f64) -> usize {
        self.crowd.nearest(discs(self.body, pose), t)
    }

    /// The time after `t` s at which movers would meet a robot that stays at `pose`, s: if they go on, and if they turn around at `t`. Infinite, or more than
    /// `most`, where that takes longer than `most` s.
    #[inline]
    pub fn met(&self, pose: [f64; 3], t: f64, most: f64) -> [f64; 2] {
        let mut first = [f64::INFINITY; 2];
        // A mover that turns around goes back where it came from: one line for both.
        self.crowd.comers(discs(self.body, pose), [t - most, t + most], |near, (p, r)| {
            let (at, v) = (near.track.position, near.track.velocity);
            let away = [p[0] - at[0] - v[0] * t, p[1] - at[1] - v[1] * t];
            let keep = near.radius + r + near.keep + near.growth * t;
            let times = [v, [-v[0], -v[1]]].map(|v| contact(away, v, keep));
            first = [first[0].min(times[0]), first[1].min(times[1])];
        });
        first
    }

    /// Distance of the discs at `pose` to the nearest obstacle, movers `t` s from now at constant velocity, m, capped.
    pub fn nearest(&self, pose: [f64; 3], t: f64, cap: f64) -> f64 {
        let disc = |(c, r): (Point, f64)| {
            let movers = self.crowd.near().iter().map(|near| near.distance(c, t)).fold(f64::INFINITY, f64::min);
            movers.min(self.clear(c, cap + r)) - r
        };
        discs(self.body, pose).map(disc).fold(cap, f64::min)
    }

    /// Smallest distance of the exact footprint at `pose` to what a mover could have reached after `t` s, m, and its number: its outline grown by
    /// `doubt + bound * t`. Movers in `but` are left out.
    pub fn reach(&self, pose: [f64; 3], t: f64, but: &[usize]) -> (f64, usize) {
        let p = [pose[0], pose[1]];
        let mut least = (f64::INFINITY, usize::MAX);
        for near in self.crowd.near().iter().filter(|n| !but.contains(&n.track.id)) {
            let grown = near.track.doubt + near.track.bound * t;
            let rough = distance(p, near.track.position) - near.radius - self.body.reach - grown;
            let exact = || {
                let q = near.track.position;
                self.body.outline.at([p[0] - q[0], p[1] - q[1], pose[2]]).gap(&near.track.outline) - grown
            };
            let gap = if rough >= least.0 || (self.body.round() && near.track.outline.points.len() == 1) { rough } else { exact() };
            if gap < least.0 {
                least = (gap, near.track.id);
            }
        }
        least
    }

    /// Puts into `part` those movers that may make a difference between two times (s) for a robot at `pose` first whose points move at most at `moves` m/s; what they
    /// mean is asked with `v` m/s.
    pub fn part(&self, pose: [f64; 3], span: [f64; 2], [v, moves]: [f64; 2], part: &mut Crowd<'a>) {
        self.crowd.part(&discs(self.body, pose), span, [v, moves], part);
    }

    /// The movers, and the radius of the disc around the reference point that covers the robot, m.
    pub fn crowd(&self) -> (&Crowd<'a>, f64) {
        (&self.crowd, self.body.reach)
    }

    /// Centre and radius (m) of the discs that hold all that movers could reach within `t` s.
    pub fn discs(&self, t: f64) -> Vec<[f64; 3]> {
        let disc = |n: &Near| [n.track.position[0], n.track.position[1], n.radius + n.track.doubt + n.track.bound * t];
        self.crowd.near().iter().map(disc).collect()
    }

    /// The largest speed that any mover may have, m/s.
    pub fn fastest(&self) -> f64 {
        self.crowd.fastest
    }

    /// Tracks that may matter.
    pub fn tracks(&self) -> impl Iterator<Item = &Track> {
        self.crowd.near().iter().map(|n| n.track)
    }

    /// First contact on the arc of constant `v` (>= 0 m/s) and `w` (rad/s) within `horizon` s: when and with what. Conservative advancement: a step
    /// is never longer than the free distance over the closing speed, or 0.01 s.
    pub fn contact(&self, pose: [f64; 3], [v, w]: [f64; 2], horizon: f64) -> Option<(f64, Met)> {
        let own = v + if self.body.round() { 0.0 } else { w.abs() * self.body.reach };
        let (mut t, mut checked) = (0.0, 0.0);
        while t <= horizon {
            let at = arc(pose, v, w, t);
            if t >= checked && (own > 0.0 || t == 0.0) {
                let slack = self.slack(at);
                if slack <= 0.0 {
                    return Some((t, Met::Static));
                }
                checked = if own > 0.0 { t + slack / own } else { f64::INFINITY };
            }
            let around = self.movers(at, t, own);
            if around.room <= 0.0 {
                return Some((t, Met::Mover(self.first(at, t))));
            }
            t += (checked - t).min(around.safe).max(LEAST);
        }
        None
    }
}

/// Is a shape certainly farther than `least` m from `p`? A no may be wrong.
#[inline]
fn surely_beyond(shape: &Shape, p: Point, least: f64) -> bool {
    let Shape::Disc { center, radius } = shape else { return false };
    let (dx, dy, limit) = (p[0] - center[0], p[1] - center[1], least + radius + SURE);
    limit > 0.0 && dx * dx + dy * dy > limit * limit
}

/// When a point that moves at `v` comes within `keep` of one that is `away` from it, s; infinite: never.
fn contact(away: Point, v: Point, keep: f64) -> f64 {
    let (toward, gap) = (away[0] * v[0] + away[1] * v[1], away[0] * away[0] + away[1] * away[1] - keep * keep);
    if gap <= 0.0 {
        return 0.0;
    }
    let speed = v[0] * v[0] + v[1] * v[1];
    let root = toward * toward - speed * gap;
    // The nearer root, without cancellation.
    if toward <= 0.0 || root < 0.0 { f64::INFINITY } else { gap / (toward + root.sqrt()) }
}

/// Centres (map frame) and radii of the discs that cover the body at `pose`.
#[inline]
fn discs(body: &Body, pose: [f64; 3]) -> impl Iterator<Item = (Point, f64)> + Clone {
    let (sin, cos) = if body.round() { (0.0, 1.0) } else { pose[2].sin_cos() };
    body.discs.iter().map(move |(c, r)| ([pose[0] + cos * c[0] - sin * c[1], pose[1] + sin * c[0] + cos * c[1]], *r))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn movers_meet_what_stands_in_their_way_at_the_time_of_contact() {
        assert!((contact([2.0, 0.0], [0.5, 0.0], 0.5) - 3.0).abs() < 1e-12);
        assert!((contact([2.0, 0.3], [0.5, 0.0], 0.5) - 3.2).abs() < 1e-12);
        assert_eq!(contact([2.0, 0.0], [-0.5, 0.0], 0.5), f64::INFINITY);
        assert_eq!(contact([2.0, 0.6], [0.5, 0.0], 0.5), f64::INFINITY);
        assert_eq!(contact([2.0, 0.0], [0.0, 0.0], 0.5), f64::INFINITY);
        assert_eq!(contact([0.2, 0.0], [-0.5, 0.0], 0.5), 0.0);
    }
}
