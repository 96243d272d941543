//! Rates of rows by time: of torques, N m/s.
//!
//! A row `a u + b x + d sqrt(x) + c` changes by `a j + (a' + 2 b) v u + b' v^3 + d u + d' v^2 + c' v` by time (`v`, `u`, `j`: path speed, acceleration and
//! jerk; `'`: by arc length). In the time of the reference this is a limit like one of jerk, with a part for each power of the speed: the third of inertia,
//! the second of viscous friction, the first of gravity.

use super::lines::Row;
use super::turns::Stretch;
use super::used::Used;
use crate::error::PlanError;
use crate::timing::Piece;
use crate::timing::scurve::advance;
use crate::timing::topp::problem::scale;
use crate::timing::topp::rows::Rows;
use crate::timing::topp::table::Table;

/// Number of the kind among the uses of limits.
pub(super) const RATE: usize = 4;
/// How far inside pieces and beside breaks the rows are read, as a share of the path.
const ASIDE: f64 = 1e-12;

/// Rows and their derivatives by arc length at places.
pub(super) struct Rates {
    rows: Rows,
    slopes: Rows,
}

impl Rates {
    /// At arc lengths.
    pub fn at(table: &mut Table, s: &[f64]) -> Result<Self, PlanError> {
        let rows = table.at(s)?.checked(s.len())?;
        if let Some(i) = (0..rows.low.len()).find(|i| rows.low[*i] >= 0.0 || rows.high[*i] <= 0.0) {
            return Err(PlanError::bad(
                "rates.low, rates.high",
                format!("{} and {}", rows.low[i], rows.high[i]),
                "low < 0 < high: at rest nothing changes",
            ));
        }
        Ok(Self { rows, slopes: table.slopes(s)? })
    }

    /// Rows per place.
    pub fn count(&self) -> usize {
        self.rows.count
    }

    fn bounds(&self, i: usize) -> [f64; 2] {
        [self.rows.low[i], self.rows.high[i]]
    }

    /// The rate of row `i` (place after place) where the reference moves with a speed, an acceleration and a jerk.
    fn rate(&self, i: usize, [v, u, j]: [f64; 3]) -> Row {
        let (rows, slopes) = (&self.rows, &self.slopes);
        let (a, turn) = (rows.a[i], slopes.a[i] + 2.0 * rows.b[i]);
        let [d, bend] = [rows, slopes].map(|rows| rows.d.get(i).copied().unwrap_or(0.0));
        Row {
            rooted: [a * j + v * (turn * u + slopes.b[i] * v * v), 3.0 * a * u + turn * v * v, a * v],
            root: slopes.c[i] * v,
            plain: [d * u + bend * v * v, d * v],
            ..Row::default()
        }
    }

    /// The limit of the rate of row `i`, its bounds divided by `tight`.
    pub fn limit(&self, i: usize, moving: [f64; 3], tight: f64) -> Row {
        let [low, high] = closed(self.bounds(i));
        let inverse = 2.0 * tight / (high - low);
        let Row { rooted, root, plain, .. } = self.rate(i, moving);
        Row {
            rooted: rooted.map(|part| part * inverse),
            root: root * inverse,
            plain: plain.map(|part| part * inverse),
            constant: -(high + low) / (high - low),
            ..Row::default()
        }
    }

    /// Parts of the rate by the power of the speed that they fall with.
    fn parts(&self, i: usize, moving: [f64; 3]) -> [f64; 3] {
        let Row { rooted, root, plain, .. } = self.rate(i, moving);
        [root, plain[0], rooted[0]]
    }
}

/// Bounds on both sides: a missing one far away.
fn closed([low, high]: [f64; 2]) -> [f64; 2] {
    match (low.is_finite(), high.is_finite()) {
        (true, true) => [low, high],
        (true, false) => [low, -1e3 * low],
        (false, true) => [-1e3 * high, high],
        (false, false) => [-1e300, 1e300],
    }
}

/// How long the rates take, on average, to build up the path acceleration of the second-order motion, s.
pub(super) fn ramp(table: &mut Table, stretch: &Stretch) -> Result<f64, PlanError> {
    let (mut s, mut middles) = (stretch.ends[0], Vec::with_capacity(stretch.legs.len()));
    for leg in stretch.legs {
        let way = advance((0.0, leg.speed, leg.acceleration), leg.jerk, leg.duration).0;
        middles.push(s + 0.5 * way);
        s += way;
    }
    let rows = table.at(&middles)?;
    let share = |i: usize| 2.0 * rows.a[i].abs() / (rows.high[i] - rows.low[i]);
    let slowest = |k: usize| (k * rows.count..(k + 1) * rows.count).map(share).fold(0.0, f64::max);
    let sum: f64 = stretch.legs.iter().enumerate().map(|(k, leg)| leg.duration * leg.acceleration.abs() * slowest(k)).sum();
    let mean = sum / stretch.duration();
    Ok(if mean.is_finite() { mean } else { 0.0 })
}

/// A place of a piece: arc length, where it is read, speed, acceleration, jerk.
struct Spot {
    s: f64,
    moving: [f64; 3],
    piece: usize,
    /// Whether it continues the two places before.
    follows: bool,
}

/// The places of the check: even in time, and both sides of breaks.
fn spots(pieces: &[Piece], count: usize, breaks: &[f64], aside: f64) -> Vec<Spot> {
    let mut spots = Vec::with_capacity(pieces.len() * (count + 1));
    for (piece, along) in pieces.iter().enumerate() {
        let Piece::Along { s, speed, acceleration, jerk, duration, .. } = *along else { continue };
        let start = (s, speed, acceleration);
        let end = advance(start, jerk, duration).0;
        let near = aside.min(0.5 * (end - s).max(0.0));
        let between = |from: f64, to: f64| breaks.partition_point(|b| *b <= to) - breaks.partition_point(|b| *b <= from);
        let mut past = [s; 2];
        for j in 0..=count {
            let (at, v, u) = advance(start, jerk, duration * j as f64 / count as f64);
            let at = at.max(s + near).min(end - near);
            spots.push(Spot { s: at, moving: [v, u, jerk], piece, follows: j >= 2 && between(past[0], at) == 0 });
            past = [past[1], at];
        }
        let first = breaks.partition_point(|b| *b <= s + near);
        for at in breaks[first..].iter().take_while(|b| **b < end - near) {
            let (_, v, u) = advance(start, jerk, super::used::reached(start, jerk, duration, *at));
            spots.extend([at - near, at + near].map(|s| Spot { s, moving: [v, u, jerk], piece, follows: false }));
        }
    }
    spots
}

/// Adds the use of the limits of rates, at `count + 1` places of each piece and on both sides of `breaks`; between places as parabolas do.
pub(super) fn used(table: &mut Table, pieces: &[Piece], count: usize, breaks: &[f64], used: &mut [Used]) -> Result<(), PlanError> {
    let spots = spots(pieces, count, breaks, ASIDE * table.length());
    let rates = Rates::at(table, &spots.iter().map(|spot| spot.s).collect::<Vec<f64>>())?;
    for r in 0..rates.count() {
        let mut past = [0.0f64; 2];
        for (k, spot) in spots.iter().enumerate() {
            let i = k * rates.count() + r;
            let (parts, [low, high]) = (rates.parts(i, spot.moving), rates.bounds(i));
            let (value, size) = (parts.iter().sum::<f64>(), scale([low, high]));
            let share = 1.0 + (value - high).max(low - value) / size;
            let bulge = if spot.follows { (2.0 * past[1] - past[0] - share).max(0.0) / 8.0 } else { 0.0 };
            let used = &mut used[spot.piece / 2];
            used.note(RATE, share, r);
            if spot.follows {
                used.note(RATE, share.max(past[1]) + bulge, r);
            }
            if share + bulge > 1.0 {
                let less = bulge.min(0.5) * size;
                used.slower = used.slower.max(slowdown(parts, [low + less, high - less]));
            }
            past = [past[1], share];
        }
    }
    Ok(())
}

/// By how much a motion must become slower for a rate of three parts (falling with the speed, its square, its cube) to be within bounds on both sides of 0.
fn slowdown([once, twice, thrice]: [f64; 3], [low, high]: [f64; 2]) -> f64 {
    let kept = |g: f64| (low..=high).contains(&(g * (once + g * (twice + g * thrice))));
    if kept(1.0) || low >= 0.0 || high <= 0.0 {
        return 1.0;
    }
    let (mut slow, mut fast) = (0.0, 1.0);
    for _ in 0..60 {
        let middle = 0.5 * (slow + fast);
        if kept(middle) {
            slow = middle;
        } else {
            fast = middle;
        }
    }
    1.0 / f64::max(slow, 1e-6)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_slower_motion_meets_its_bound() {
        for parts in [[1.0, 0.5, 3.0], [0.0, 0.0, 24.0], [-4.0, 0.0, 0.0], [2.0, -1.0, -9.0]] {
            let g = 1.0 / slowdown(parts, [-3.0, 3.0]);
            let value = g * (parts[0] + g * (parts[1] + g * parts[2]));
            assert!((value.abs() - 3.0).abs() < 1e-12, "{parts:?} {g}");
        }
        assert_eq!(slowdown([1.0, 1.0, 0.5], [-3.0, 3.0]), 1.0);
        assert_eq!(slowdown([0.0, 0.0, 24.0], [-3.0, 3.0]), 2.0);
    }
}
