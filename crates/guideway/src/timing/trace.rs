//! Speed, ceiling and overspeed regions over the arc length, for records and pictures.

use super::ceiling::Ceiling;
use super::jerk_limited::Loop;
use super::overspeed::{Region, regions};
use super::scurve::Profile;
use serde::{Deserialize, Serialize};

/// Most rows of a curve.
const ROWS: usize = 400;

/// A profile before and after correction under its ceiling. Rows are (arc length in m, speed in m/s), at most about 400 a curve.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize)]
pub struct SpeedTrace {
    /// Lowest ceiling in each stretch, at its middle.
    pub ceiling: Vec<[f64; 2]>,
    /// The first pass.
    pub before: Vec<[f64; 2]>,
    /// The result.
    pub after: Vec<[f64; 2]>,
    /// Overspeed regions of the first pass.
    pub regions_before: Vec<Region>,
    /// Overspeed regions of the result.
    pub regions_after: Vec<Region>,
}

impl SpeedTrace {
    /// The loops of a whole path.
    pub fn of(loops: &[Loop]) -> Self {
        let length: f64 = loops.iter().map(|part| part.ceiling.length()).sum();
        let mut trace = Self::default();
        for part in loops {
            trace.add(part.from, part.ceiling.length() / length, &part.ceiling, [&part.corrected.first, &part.corrected.chain]);
        }
        trace
    }

    /// Adds a stretch of the path that begins at arc length `from` (m): its ceiling, and the chains of profiles before and after. `share` of the rows, 0 to 1.
    pub fn add(&mut self, from: f64, share: f64, ceiling: &Ceiling, [before, after]: [&[(f64, Profile)]; 2]) {
        let most = ((ROWS as f64 * share) as usize).max(2);
        let (cells, h) = (ceiling.cells(), ceiling.step());
        let width = cells.len().div_ceil(most);
        self.ceiling.extend(cells.chunks(width).enumerate().map(|(i, chunk)| {
            let middle = h * ((i * width) as f64 + 0.5 * chunk.len() as f64);
            [from + middle, chunk.iter().copied().fold(f64::INFINITY, f64::min)]
        }));
        for (chain, rows, found) in [(before, &mut self.before, &mut self.regions_before), (after, &mut self.after, &mut self.regions_after)] {
            rows.extend(sampled(chain, most).into_iter().map(|[s, v]| [from + s, v]));
            found.extend(regions(chain, ceiling).into_iter().map(|r| Region { from: from + r.from, to: from + r.to, worst: from + r.worst, ..r }));
        }
    }
}

/// A chain at equal steps of time, both ends included.
fn sampled(chain: &[(f64, Profile)], count: usize) -> Vec<[f64; 2]> {
    let total: f64 = chain.iter().map(|(_, p)| p.duration()).sum();
    let (mut rows, mut begun, mut k) = (Vec::with_capacity(count), 0.0, 0);
    for (i, (from, profile)) in chain.iter().enumerate() {
        let end = begun + profile.duration();
        let last = i + 1 == chain.len();
        while k < count {
            let t = total * k as f64 / (count - 1) as f64;
            if t > end && !last {
                break;
            }
            let (s, v, ..) = profile.at(t - begun);
            rows.push([from + s, v]);
            k += 1;
        }
        begun = end;
    }
    rows
}
