//! Perception: what a robot makes of its scans.
//!
//! Scan points that the static world does not explain are grouped and tracked. Without a map the static world is what was hit before, and a point counts as
//! unexplained where rays have passed. What stays where it is for a second becomes part of the static world. Poses are filtered with odometry first.

mod blobs;
mod map;
mod tiles;
mod tracks;

use super::filter::Filter;
use super::{Lidar, Observation, Scan};
use crate::Point;
use crate::error::PlanError;
use crate::world::shape::distance;
use crate::world::{ClearanceField, World};
use blobs::{Blob, Dot, blobs};
use map::LocalMap;
use std::f64::consts::TAU;
use std::sync::Arc;
use tracks::Tracks;

/// Trust in each observed pose against odometry, 0 to 1.
const TRUST: f64 = 0.2;
/// Points this near to what the map shows belong to it, m, and so much more per metre of range (headings are noisy).
const EXPLAINED: f64 = 0.08;
const SLANT: f64 = 0.01;
/// Rays that end nearer than this measure nothing: what covers the lidar blinds it, m.
const LEAST: f64 = 0.05;
/// Two returns this near to each other belong to one thing, whatever the rays between them say, m.
const GAP: f64 = 0.15;
/// A gap in time beyond this ends all tracks, s.
const LAPSE: f64 = 1.0;
/// Largest top speed of what moves that can be told, m/s.
const FASTEST: f64 = 100.0;

/// Turns scans into what controllers see.
pub struct Eyes {
    beams: usize,
    /// The given map and its distances.
    base: Option<(Arc<World>, Arc<ClearanceField>)>,
    map: LocalMap,
    filter: Filter,
    tracks: Tracks,
    /// Time of the newest good scan, s.
    last: Option<f64>,
    /// Time of the newest observation, s.
    now: f64,
    scan: Option<Arc<Scan>>,
    dots: Vec<Dot>,
    blobs: Vec<Blob>,
}

impl Eyes {
    /// Eyes behind a lidar in a world whose static part is known, or (`map_known` false) only its bounds.
    /// # Errors
    /// [`PlanError::BadParameter`] for a lidar out of range, and for a map of more than 67 million cells.
    pub fn new(lidar: Lidar, world: &Arc<World>, map_known: bool) -> Result<Self, PlanError> {
        let lidar = lidar.validated()?;
        Ok(Self {
            beams: lidar.beams as usize,
            // What is only forbidden explains nothing that is seen.
            base: map_known.then(|| Arc::new(world.solid().overlaid(Vec::new()))).map(|solid| (Arc::clone(&solid), solid.clearance_field())),
            map: LocalMap::new(world, map_known)?,
            filter: Filter::new(TRUST),
            tracks: Tracks::new(None),
            last: None,
            now: f64::NEG_INFINITY,
            scan: None,
            dots: Vec::new(),
            blobs: Vec::new(),
        })
    }

    /// With the top speed (m/s) of whatever moves here: the bound of every track. Without it 1 m/s or 1.2 times the speed of the track.
    /// # Errors
    /// [`PlanError::BadParameter`] for a speed out of range.
    pub fn with_mover_speed(mut self, mover_speed: Option<f64>) -> Result<Self, PlanError> {
        if let Some(speed) = mover_speed.filter(|v| !(0.0..=FASTEST).contains(v)) {
            return Err(PlanError::bad("mover_speed", speed, format!("0 to {FASTEST} m/s")));
        }
        self.tracks = Tracks::new(mover_speed);
        Ok(self)
    }

    /// Fills tracks, known world, age and scan of an observation (time, pose and speeds are there) from a new scan, if there is one. A scan with another
    /// number of rays than the lidar has, with fewer than half of its rays measured (0.05 m and more), or not newer than the last one, is no look; nor is one at a pose
    /// that is not finite. When time runs backwards or makes a leap, movers are forgotten and the next scan counts.
    pub fn look(&mut self, seen: &mut Observation, scan: Option<Scan>) {
        let finite = seen.time.is_finite() && seen.pose.iter().chain([&seen.v, &seen.w]).all(|v| v.is_finite());
        if finite {
            self.clock(seen.time);
            let mut at = seen.clone();
            self.filter.apply(&mut at);
            if let Some(mut scan) = scan
                && self.good(&scan, seen.time)
            {
                mend(&mut scan);
                self.take(at.pose, Arc::new(scan));
            }
        }
        seen.age = match self.last {
            Some(t) if finite => (seen.time - t).abs(),
            _ => f64::INFINITY,
        };
        seen.scan.clone_from(&self.scan);
        seen.known = self.map.world().cloned();
        seen.tracks.clear();
        seen.tracks.extend(self.tracks.told(seen.time));
    }

    /// Time goes on to `now`; after a leap everything that moves is forgotten.
    fn clock(&mut self, now: f64) {
        let dt = now - self.now;
        if !(0.0..=LAPSE).contains(&dt) && self.now.is_finite() {
            self.tracks.clear();
            self.filter = Filter::new(TRUST);
            self.last = None;
        }
        self.now = now;
    }

    fn good(&self, scan: &Scan, now: f64) -> bool {
        let fresh = (now - scan.time).abs() <= LAPSE && self.last.is_none_or(|t| scan.time > t);
        let angles = scan.first.is_finite() && scan.step.is_finite() && scan.step > 0.0;
        let measured = scan.ranges.iter().filter(|r| **r >= LEAST).count();
        fresh && angles && scan.range > 0.0 && scan.ranges.len() == self.beams && 2 * measured >= self.beams
    }

    /// Works a good scan in, taken at `pose`.
    fn take(&mut self, pose: [f64; 3], scan: Arc<Scan>) {
        let origin = [pose[0], pose[1]];
        self.tracks.predict(scan.time);
        self.unexplained(pose, &scan);
        let closed = scan.step * self.beams as f64 > TAU - 1.5 * scan.step;
        blobs(&self.dots, origin, (scan.step, &scan.ranges, closed), &mut self.blobs);
        let open = |p: Point, radius: f64| {
            let angle = (p[1] - origin[1]).atan2(p[0] - origin[0]) - pose[2] - scan.first;
            let ray = (angle.rem_euclid(TAU) / scan.step).round() as usize;
            scan.ranges.get(ray).is_some_and(|r| *r > distance(p, origin) + radius)
        };
        self.tracks.update(&self.blobs, scan.time, open);
        self.last = Some(scan.time);
        self.scan = Some(scan);
    }

    /// Collects the points that the static world does not explain; all others go into the map that is being made.
    fn unexplained(&mut self, pose: [f64; 3], scan: &Scan) {
        self.dots.clear();
        let origin = [pose[0], pose[1]];
        self.map.fade(scan.time);
        for (ray, r) in scan.ranges.iter().enumerate().filter(|(_, r)| **r >= LEAST) {
            let (s, c) = (pose[2] + scan.first + scan.step * ray as f64).sin_cos();
            let range = r.min(scan.range);
            let at = [origin[0] + range * c, origin[1] + range * s];
            let ends = *r <= scan.range;
            let explained = ends && self.base.as_ref().is_some_and(|(world, field)| explained(world, field, at, range));
            let moving = ends && !explained && self.strange(at);
            if !self.map.idle() {
                self.map.miss(origin, [c, s], if ends { range } else { agreed(scan, ray) });
            }
            if moving {
                if !self.tracks.cover(at) {
                    self.map.linger(at, scan.time);
                }
                self.dots.push(Dot { ray, at, range });
            } else if ends && !explained {
                self.map.hit(at);
            }
        }
    }

    /// Is there something at `at` where there was nothing?
    fn strange(&self, at: Point) -> bool {
        self.tracks.cover(at) || self.map.certainly_free(at) || (self.base.is_some() && !self.map.shows(at))
    }
}

/// How far a ray that met nothing frees cells, m: no farther than the longer of its neighbours, since single rays get lost. 0 without a neighbour.
fn agreed(scan: &Scan, ray: usize) -> f64 {
    let beside = [ray.checked_sub(1), Some(ray + 1)].into_iter().flatten().filter_map(|i| scan.ranges.get(i));
    beside.filter(|r| **r >= LEAST).fold(0.0, |far: f64, r| far.max(*r)).min(scan.range)
}

/// Does the map show something at (or beside) a point? Points outside the map are not its business.
fn explained(world: &World, field: &ClearanceField, at: Point, range: f64) -> bool {
    let near = EXPLAINED + SLANT * range;
    let cell = match world.grid() {
        Some(grid) => grid.cell_at(at),
        None => world.contains(at).then(|| {
            let [x0, y0, ..] = world.bounds();
            let [w, h] = world.cells();
            let side = world.resolution();
            [(((at[0] - x0) / side) as u32).min(w - 1), (((at[1] - y0) / side) as u32).min(h - 1)]
        }),
    };
    // The centre of the cell is at most 0.71 sides away.
    cell.is_none_or(|cell| field.at(cell) < near + 0.71 * world.resolution())
}

/// Closes gaps of rays without a return between two returns that lie no more than [`GAP`] apart: rays that failed would tear what is there into pieces that seem
/// to move, and open the map behind it; no robot passes a gap that is real.
fn mend(scan: &mut Scan) {
    let returned = |r: f64| r.is_finite() && r >= LEAST;
    let mut last: Option<usize> = None;
    for i in 0..scan.ranges.len() {
        if !returned(scan.ranges[i]) {
            continue;
        }
        if let Some(from) = last.filter(|from| i - from > 1) {
            let (a, b, angle) = (scan.ranges[from], scan.ranges[i], scan.step * (i - from) as f64);
            if a * a + b * b - 2.0 * a * b * angle.cos() <= GAP * GAP {
                for k in from + 1..i {
                    scan.ranges[k] = a + (b - a) * (k - from) as f64 / (i - from) as f64;
                }
            }
        }
        last = Some(i);
    }
}

#[cfg(test)]
mod tests;
