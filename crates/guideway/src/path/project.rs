//! The nearest place on a path, going forward only.

use super::bspline::Path;
use crate::Point;
use crate::world::shape::{cross, distance, dot, sub};

/// Samples per polynomial piece inside the window.
const SAMPLES: f64 = 8.0;

impl Path {
    /// Nearest place to `p` (m) on the planar path with arc length in `[s_from, s_from + window]` (m): its arc length (m) and the signed lateral
    /// distance of `p` from it (m, positive to the left of the direction of travel). Never goes back behind `s_from`, so a caller that feeds the
    /// result into the next call gets a monotone projection.
    pub fn project(&self, p: Point, s_from: f64, window: f64) -> (f64, f64) {
        let length = self.length();
        let low = s_from.clamp(0.0, length);
        let high = (s_from + window.max(0.0)).clamp(low, length);
        let mut best = (f64::INFINITY, low);
        for (a, b) in self.stretches(low, high) {
            let n = if self.degree() == 1 { 1.0 } else { SAMPLES };
            for i in 0..n as u32 {
                let (x, y) = (a + (b - a) * f64::from(i) / n, a + (b - a) * f64::from(i + 1) / n);
                let s = self.nearest(p, x, y);
                let d = distance(self.planar(s).point, p);
                if d < best.0 {
                    best = (d, s);
                }
            }
        }
        let place = self.planar(best.1);
        let v = sub(p, place.point);
        let side = cross([place.heading.cos(), place.heading.sin()], v);
        let d = distance(place.point, p);
        (best.1, if side < 0.0 { -d } else { d })
    }

    /// The parts of polynomial pieces between `low` and `high`.
    fn stretches(&self, low: f64, high: f64) -> Vec<(f64, f64)> {
        let table = self.table();
        if table.leaves.is_empty() {
            return vec![(low, high)];
        }
        let mut stretches: Vec<(f64, f64)> = Vec::new();
        let mut last = usize::MAX;
        for leaf in &table.leaves[table.leaf_at(low)..=table.leaf_at(high)] {
            let (a, b) = (leaf.s[0].max(low), leaf.s[1].min(high));
            match stretches.last_mut() {
                Some(open) if last == leaf.piece => open.1 = b,
                _ => stretches.push((a, b)),
            }
            last = leaf.piece;
        }
        stretches
    }

    /// Nearest arc length in a short bracket: exact on a straight leg, else by safeguarded Newton steps on (r(s) - p) . r'(s) = 0.
    fn nearest(&self, p: Point, mut low: f64, mut high: f64) -> f64 {
        let slope = |s: f64| {
            let place = self.planar(s);
            let (sin, cos) = place.heading.sin_cos();
            let v = sub(place.point, p);
            (dot(v, [cos, sin]), 1.0 + place.curvature * cross([cos, sin], v))
        };
        if self.degree() == 1 {
            let (along, _) = slope(low);
            return (low - along).clamp(low, high);
        }
        if slope(low).0 >= 0.0 {
            return low;
        }
        if slope(high).0 <= 0.0 {
            return high;
        }
        let mut s = f64::midpoint(low, high);
        for _ in 0..40 {
            let (f, df) = slope(s);
            if f > 0.0 {
                high = s;
            } else {
                low = s;
            }
            let next = if df > 0.0 { s - f / df } else { f64::NAN };
            let next = if next > low && next < high { next } else { f64::midpoint(low, high) };
            if (next - s).abs() <= 1e-12 * (1.0 + s) {
                return next;
            }
            s = next;
        }
        s
    }
}
