//! One axis in exactly a given duration.
//!
//! The usual motion goes to a cruising speed, keeps it, and leaves it. For a fixed duration its speed at every instant grows with the
//! cruising speed, so the distance does, and a bracketed root is the cruising speed. Where no cruising speed fits (durations a little
//! above the shortest), two motions of that duration, one too short and one too long, are mixed: the set of motions of a fixed duration
//! is convex, so the mixture keeps every limit and covers the distance exactly.

use super::leg::{Leg, Shape, blend};
use super::line::Line;
use super::root;
use super::widest::Widest;
use crate::timing::scurve::Phase;

/// Where the cruising speed lies, seen from the two resting speeds; the number is its distance from the nearer one.
#[derive(Debug, Clone, Copy, PartialEq)]
enum Zone {
    /// Above both.
    Above,
    /// Below both.
    Below,
    /// Between them, counted from the lower one.
    FromLow,
    /// Between them, counted from the higher one.
    FromHigh,
}

/// A cruising motion.
struct Cruise {
    legs: [Leg; 2],
    signs: [f64; 2],
    speed: f64,
    /// s, negative if the legs take too long.
    hold: f64,
    distance: f64,
    /// Distance per cruising speed, s, and its derivative.
    slope: f64,
    bend: f64,
}

/// The cruising motions of one axis in a given time.
struct Cruises<'a> {
    line: &'a Line,
    time: f64,
    rests: [f64; 2],
    /// Which of the two is the lower one.
    low: usize,
    gap: f64,
}

impl Cruises<'_> {
    fn new(line: &Line, time: f64) -> Cruises<'_> {
        let gap = line.gap();
        Cruises { line, time, rests: line.rests(), low: usize::from(gap < 0.0), gap: gap.abs() }
    }

    #[inline]
    fn at(&self, zone: Zone, z: f64) -> Cruise {
        let Line { start, end, up, down, jerk, inverse, .. } = *self.line;
        let (low, high) = (self.low, 1 - self.low);
        // (rise above the lower resting speed, distance from the higher one, direction from each, cruising speed)
        let (from_low, from_high, sign_low, sign_high, speed) = match zone {
            Zone::Above => (self.gap + z, z, 1.0, 1.0, self.rests[high] + z),
            Zone::Below => (z, self.gap + z, -1.0, -1.0, self.rests[low] - z),
            Zone::FromLow => (z, self.gap - z, 1.0, -1.0, self.rests[low] + z),
            Zone::FromHigh => (self.gap - z, z, 1.0, -1.0, self.rests[high] - z),
        };
        let (mut away, mut signs) = ([0.0; 2], [0.0; 2]);
        (away[low], away[high], signs[low], signs[high]) = (from_low, from_high, sign_low, sign_high);
        let leg = |i: usize, a: f64, rising: f64, falling: f64| {
            let limit = if signs[i] > 0.0 { rising } else { falling };
            Leg::new(jerk * away[i] + a.max(0.0).powi(2), (a, 0.0), limit, (jerk, inverse))
        };
        // The second leg is seen in reversed time.
        let legs = [leg(0, signs[0] * start.1, up, down), leg(1, -signs[1] * end.1, down, up)];
        let hold = self.time - legs[0].time() - legs[1].time();
        Cruise {
            distance: speed * self.time - signs[0] * legs[0].area - signs[1] * legs[1].area,
            bend: -signs[0] * legs[0].bend() - signs[1] * legs[1].bend(),
            slope: hold + (legs[0].peak + legs[1].peak) * (0.5 * inverse),
            legs,
            signs,
            speed,
            hold,
        }
    }

    /// Slack of durations, s.
    fn slack(&self) -> f64 {
        1e-14 * self.time
    }

    fn fits(&self, cruise: &Cruise) -> bool {
        cruise.hold >= -self.slack()
    }

    /// The cruising speed between `0` and `most` of a zone that covers `distance`.
    fn find(&self, zone: Zone, most: f64, distance: f64) -> Cruise {
        let sign = if matches!(zone, Zone::Above | Zone::FromLow) { 1.0 } else { -1.0 };
        let guess = if self.time > 0.0 { sign * (distance / self.time - self.at(zone, 0.0).speed) } else { 0.0 };
        let z = root::rising((0.0, most), guess, |z| {
            let cruise = self.at(zone, z);
            // Beyond the last cruising speed that fits the search turns back.
            let y = if self.fits(&cruise) { sign * (cruise.distance - distance) } else { f64::INFINITY };
            (y, cruise.slope, sign * cruise.bend)
        });
        // Near the last one the distance is flat in the cruising speed, and rounding may lead beyond it.
        let found = self.at(zone, z);
        if found.hold < -self.slack() { self.at(zone, self.edge(zone, z)) } else { found }
    }

    /// The last place of a zone, up to `most`, whose legs still fit.
    fn edge(&self, zone: Zone, most: f64) -> f64 {
        root::rising((0.0, most), f64::NAN, |z| {
            let cruise = self.at(zone, z);
            let part = |peak: f64| if peak > 0.0 { 1.0 / peak } else { f64::INFINITY };
            let (low, high) = (part(cruise.legs[self.low].peak), part(cruise.legs[1 - self.low].peak));
            let longer = match zone {
                Zone::Above | Zone::Below => low + high,
                Zone::FromLow => low - high,
                Zone::FromHigh => high - low,
            };
            (-cruise.hold, longer, 0.0)
        })
    }

    fn shape(&self, cruise: &Cruise) -> Shape {
        let jerk = self.line.jerk;
        let mut shape = Shape::new();
        cruise.legs[0].phases(cruise.signs[0], jerk).iter().for_each(|p| shape.push(p.duration, p.jerk));
        shape.push(cruise.hold, 0.0);
        cruise.legs[1].phases(cruise.signs[1], jerk).iter().rev().for_each(|p| shape.push(p.duration, p.jerk));
        shape
    }

    /// Where between the resting speeds, counted from the lower one, the legs take longest.
    fn slowest(&self) -> f64 {
        let outward = [self.line.start.1, -self.line.end.1];
        let (a, b) = (outward[self.low].max(0.0), (-outward[1 - self.low]).max(0.0));
        (0.5 * (self.gap + (b * b - a * a) / self.line.jerk)).clamp(0.0, self.gap)
    }
}

/// A motion of `line` over `distance` in exactly `time` seconds; the distance must be in the reach of that time, else the nearest end
/// of it is covered.
pub(super) fn exactly(line: &Line, distance: f64, time: f64, phases: &mut Vec<Phase>) {
    let all = Cruises::new(line, time);
    let (low, high) = (all.at(Zone::Below, 0.0), all.at(Zone::Above, 0.0));
    let (low_fits, high_fits) = (all.fits(&low), all.fits(&high));
    let cruise = if high_fits && distance >= high.distance {
        all.find(Zone::Above, line.speed.1 - high.speed, distance)
    } else if low_fits && distance <= low.distance {
        all.find(Zone::Below, low.speed - line.speed.0, distance)
    } else {
        return between(&all, (low_fits, high_fits), distance, phases);
    };
    phases.extend_from_slice(all.shape(&cruise).phases());
}

/// The cruising speed is between the resting speeds, or no cruise fits.
fn between(all: &Cruises<'_>, (low_fits, high_fits): (bool, bool), distance: f64, phases: &mut Vec<Phase>) {
    let slowest = all.slowest();
    let whole = all.fits(&all.at(Zone::FromLow, slowest));
    let side = |zone: Zone, most: f64| if whole { most } else { all.edge(zone, most) };
    let mut ends: [Option<(Vec<Phase>, f64)>; 2] = [None, None];
    for (zone, fits, most, slot) in [(Zone::FromLow, low_fits, slowest, 0), (Zone::FromHigh, high_fits, all.gap - slowest, 1)] {
        if !fits {
            continue;
        }
        let most = side(zone, most);
        let edge = all.at(zone, most);
        if (slot == 0 && distance <= edge.distance) || (slot == 1 && distance >= edge.distance) {
            return phases.extend_from_slice(all.shape(&all.find(zone, most, distance)).phases());
        }
        ends[slot] = Some((all.shape(&edge).phases().to_vec(), edge.distance));
    }
    let [lower, upper] = ends;
    let lower = lower.unwrap_or_else(|| extreme(&Widest::new(all.line, true), all.time));
    let upper = upper.unwrap_or_else(|| extreme(&Widest::new(all.line, false), all.time));
    phases.extend(mixed(lower, upper, distance));
}

/// The member of a family that takes this long, and what it covers.
fn extreme(family: &Widest, time: f64) -> (Vec<Phase>, f64) {
    let (place, covered) = family.lasting(time);
    (family.shape(&place).phases().to_vec(), covered)
}

/// A motion between the extremes of two families in exactly `time`.
pub(super) fn amid(families: &[Widest; 2], distance: f64, time: f64) -> Vec<Phase> {
    mixed(extreme(&families[1], time), extreme(&families[0], time), distance)
}

/// Two motions, each with what it covers, mixed so that `distance` is covered.
fn mixed((short, least): (Vec<Phase>, f64), (long, most): (Vec<Phase>, f64), distance: f64) -> Vec<Phase> {
    let share = if most > least { ((distance - least) / (most - least)).clamp(0.0, 1.0) } else { 0.5 };
    blend(&short, &long, share)
}
