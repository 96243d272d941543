//! The use of the limits on the pieces of a jerk-limited motion.

use super::pieces::Walker;
use crate::error::PlanError;
use crate::timing::Piece;
use crate::timing::scurve::advance;
use crate::timing::topp::course::Shape;
use crate::timing::topp::limits::Bounds;
use crate::timing::topp::problem::{Demands, checked_ceiling, scale};
use crate::timing::topp::rows::Rows;

/// Owner of the use of a ceiling.
pub(in crate::timing::topp) const CEILING: usize = usize::MAX;

/// Use of the limits of speed, acceleration, jerk, of the rows called for and of the rates of rows on a pair of pieces: 1 is the bound.
#[derive(Debug, Clone, Copy)]
pub(in crate::timing::topp) struct Used {
    pub share: [f64; 5],
    /// The joint or the row that uses most of each.
    pub owner: [usize; 5],
    /// By how much the motion must become slower to keep the rows and their rates.
    pub slower: f64,
}

impl Default for Used {
    fn default() -> Self {
        Self { share: [0.0; 5], owner: [0; 5], slower: 1.0 }
    }
}

impl Used {
    pub fn note(&mut self, kind: usize, share: f64, owner: usize) {
        if share > self.share[kind] {
            (self.share[kind], self.owner[kind]) = (share, owner);
        }
    }

    /// By how much the motion must become slower to keep all limits.
    pub fn slower(&self) -> f64 {
        self.slower.max(self.share[0]).max(self.share[1].sqrt()).max(self.share[2].cbrt())
    }

    /// Of the motion slowed down by a factor; the rows and their rates stay as they are.
    pub fn slowed(mut self, factor: f64) -> Self {
        for (share, power) in self.share.iter_mut().take(3).zip(1..) {
            *share /= factor.powi(power);
        }
        self
    }
}

/// Use of the limits of speed, acceleration and jerk on every pair of pieces, at `count` places of each piece.
pub(super) fn joints(walker: &mut Walker, pieces: &[Piece], bounds: &Bounds, count: usize) -> Vec<Used> {
    let mut used = vec![Used::default(); pieces.len() / 2];
    let mut gauge = Gauge::new(bounds);
    let mut met = 0;
    for (k, piece) in pieces.iter().enumerate() {
        let Piece::Along { s, speed, acceleration, jerk, duration, .. } = *piece else { continue };
        let (start, used) = ((s, speed, acceleration), &mut used[k / 2]);
        let mut past = [[0.0; 3]; 2];
        let share = 1.0 / count as f64;
        for j in 0..=count {
            let (s, v, a) = advance(start, jerk, duration * share * j as f64);
            let factors = walker.drive(s, [v, a, jerk]);
            let now = gauge.read(&walker.shape, factors);
            for i in 0..3 {
                let bulge = if j >= 2 { (2.0 * past[1][i] - past[0][i] - now[i]).max(0.0) / 8.0 } else { 0.0 };
                let most = now[i].max(past[1][i]) + bulge;
                if most > used.share[i] {
                    used.note(i, most, gauge.owner(i));
                }
            }
            past = [past[1], now];
        }
        // Where polynomial pieces meet, the third derivative jumps: both sides count.
        let end = advance(start, jerk, duration).0;
        while let Some((at, sides)) = walker.joints.get(met).copied().filter(|joint| joint.0 <= end) {
            met += 1;
            let (_, v, a) = advance(start, jerk, reached(start, jerk, duration, at));
            for (piece, t) in sides {
                walker.course.full_shape(piece, t, &mut walker.shape);
                let now = gauge.read(&walker.shape, [v, a, jerk]);
                (0..3).for_each(|i| used.note(i, now[i], gauge.owner(i)));
            }
        }
    }
    used
}

/// Use of the limits of every joint at one place.
struct Gauge {
    /// One over the speed, the acceleration, the jerk, the deceleration of each joint.
    inverse: [Vec<f64>; 4],
    /// Of speed, acceleration and jerk, joint by joint.
    shares: [Vec<f64>; 3],
}

impl Gauge {
    fn new(bounds: &Bounds) -> Self {
        let inverse = |v: &[f64]| v.iter().map(|v| 1.0 / v).collect::<Vec<f64>>();
        let Bounds { speed, acceleration, deceleration, jerk } = bounds;
        let zeros = || vec![0.0; speed.len()];
        Self { inverse: [speed, acceleration, jerk, deceleration].map(|v| inverse(v)), shares: [zeros(), zeros(), zeros()] }
    }

    /// The largest use of speed, acceleration and jerk of joints with the derivatives of `shape` where what they depend on has those of `moved` by time.
    fn read(&mut self, shape: &Shape, [once, twice, thrice]: [f64; 3]) -> [f64; 3] {
        let [speed, acceleration, jerk, deceleration] = &self.inverse;
        let [speeds, accelerations, jerks] = &mut self.shares;
        let joints = speeds.len();
        let (one, two, three) = (&shape.first[..joints], &shape.second[..joints], &shape.third[..joints]);
        let (square, cube, mixed) = (once * once, once * once * once, 3.0 * once * twice);
        for i in 0..joints {
            let rate = one[i] * once;
            let second = two[i] * square + one[i] * twice;
            let inverse = if rate * second >= 0.0 { acceleration[i] } else { deceleration[i] };
            speeds[i] = rate.abs() * speed[i];
            accelerations[i] = second.abs() * inverse;
            jerks[i] = (three[i] * cube + two[i] * mixed + one[i] * thrice).abs() * jerk[i];
        }
        [0, 1, 2].map(|kind| self.shares[kind].iter().fold(0.0, |most, share| if *share > most { *share } else { most }))
    }

    /// The joint that uses most of a kind of limit.
    fn owner(&self, kind: usize) -> usize {
        (0..self.shares[kind].len()).max_by(|i, j| self.shares[kind][*i].total_cmp(&self.shares[kind][*j])).unwrap_or(0)
    }
}

/// When a piece reaches an arc length.
pub(super) fn reached(start: (f64, f64, f64), jerk: f64, duration: f64, s: f64) -> f64 {
    let (mut low, mut high) = (0.0, duration);
    for _ in 0..50 {
        let middle = 0.5 * (low + high);
        if advance(start, jerk, middle).0 < s {
            low = middle;
        } else {
            high = middle;
        }
    }
    0.5 * (low + high)
}

/// Adds the use of what is called for, at `count + 1` places of each piece; between them as parabolas do, but across `breaks` of the path.
pub(super) fn demands(demands: &mut Demands, pieces: &[Piece], count: usize, breaks: &[f64], used: &mut [Used]) -> Result<(), PlanError> {
    if demands.rows.is_none() && demands.ceiling.is_none() {
        return Ok(());
    }
    let mut places = Vec::with_capacity(pieces.len() * (count + 1));
    for piece in pieces {
        if let Piece::Along { s, speed, acceleration, jerk, duration, .. } = *piece {
            places.extend((0..=count).map(|j| advance((s, speed, acceleration), jerk, duration * j as f64 / count as f64)));
        }
    }
    let s: Vec<f64> = places.iter().map(|place| place.0).collect();
    if let Some(rows) = &mut demands.rows {
        let rows = rows(&s)?.checked(s.len())?;
        for (k, places) in places.chunks_exact(count + 1).enumerate() {
            on_piece(&rows, k * (count + 1), places, breaks, &mut used[k / 2]);
        }
    }
    if let Some(ceiling) = &mut demands.ceiling {
        let top = checked_ceiling(ceiling(&s)?, s.len())?;
        for (p, ((_, v, _), top)) in places.iter().zip(top).enumerate() {
            used[p / (count + 1) / 2].note(0, if *v > 0.0 { v / top.sqrt() } else { 0.0 }, CEILING);
        }
    }
    Ok(())
}

/// Use of the rows at the places (arc length, speed, acceleration) of one piece; `first` is the number of its first place among the rows.
fn on_piece(rows: &Rows, first: usize, places: &[(f64, f64, f64)], breaks: &[f64], used: &mut Used) {
    for r in 0..rows.count {
        // Arc length, share and parts of the demand at the places before.
        let mut past = [(0.0f64, 0.0f64, [0.0; 3]); 2];
        for (j, (s, v, a)) in places.iter().enumerate() {
            let i = (first + j) * rows.count + r;
            let (bounds, parts) = ([rows.low[i], rows.high[i]], [rows.c[i], rows.d.get(i).map_or(0.0, |d| d * v), rows.a[i] * a + rows.b[i] * v * v]);
            let (value, size) = (parts[0] + parts[1] + parts[2], scale(bounds));
            let now = (*s, 1.0 + (value - bounds[1]).max(bounds[0] - value) / size, parts);
            let smooth = j >= 2 && breaks.partition_point(|b| *b < past[0].0) == breaks.partition_point(|b| b <= s);
            let bulge = if smooth { (2.0 * past[1].1 - past[0].1 - now.1).max(0.0) / 8.0 } else { 0.0 };
            let most = if now.1 > past[1].1 { now } else { past[1] };
            used.note(3, most.1 + bulge, r);
            if most.1 + bulge > 1.0 {
                used.slower = used.slower.max(slowdown(most.2, [bounds[0] + bulge * size, bounds[1] - bulge * size]));
            }
            past = [past[1], now];
        }
    }
}

/// By how much a motion must become slower for a demand of three parts (at rest, with its speed, with its squared speed) to be within bounds; 1 where it is,
/// or where rest itself is beyond them.
fn slowdown([rest, once, twice]: [f64; 3], [low, high]: [f64; 2]) -> f64 {
    let value = rest + once + twice;
    let bound = if value > high { high } else { low };
    if (low..=high).contains(&value) || rest > high || rest < low {
        return 1.0;
    }
    // twice g^2 + once g + rest = bound for the share g of the speed.
    let root = (once * once - 4.0 * twice * (rest - bound)).max(0.0).sqrt();
    let q = -0.5 * (once + root.copysign(once));
    let shares = [q / twice, (rest - bound) / q];
    shares.into_iter().filter(|g| *g > 0.0 && *g < 1.0).fold(1.0, |slower, g| f64::max(slower, 1.0 / g))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_slower_motion_meets_its_bound() {
        for parts in [[1.0, 0.5, 3.0], [-1.0, 0.0, 6.0], [0.0, 4.0, 0.0], [1.0, -2.0, 5.0], [-1.0, -2.0, -4.0]] {
            let g = 1.0 / slowdown(parts, [-3.0, 3.0]);
            let value: f64 = parts[0] + parts[1] * g + parts[2] * g * g;
            assert!((value.abs() - 3.0).abs() < 1e-12, "{parts:?} {g}");
        }
        assert_eq!(slowdown([1.0, 1.0, 0.5], [-3.0, 3.0]), 1.0);
        assert_eq!(slowdown([4.0, 1.0, 0.5], [-3.0, 3.0]), 1.0);
    }
}
