//! The speed at the top: solves `D(w) = distance` for the two sides of a profile that meet at speed `w` with zero acceleration.

/// One side, seen from its boundary state towards the top: acceleration rises with jerk `near` from `a` to a peak, holds there if
/// the limit is reached, and falls with jerk `far` to zero. The deceleration side is the same thing in reversed time.
///
/// The boundary state lies on a ramp that began at a virtual state `(base, 0)`, so the formulas are those of a start at zero acceleration.
#[derive(Debug, Clone, Copy)]
pub struct Side {
    /// Boundary acceleration, m/s2, >= 0.
    a: f64,
    /// Virtual speed where the ramp began, m/s (may be negative).
    base: f64,
    /// Distance from the virtual state to the boundary state, m.
    skipped: f64,
    /// 1 / near, 1 / far, s3/m.
    inverse: (f64, f64),
    /// `1 / near + 1 / far`: the side gains `k p^2 / 2` at peak acceleration `p`.
    k: f64,
    /// 2 / k.
    two_over_k: f64,
    /// Cubic coefficient of the distance over `p`.
    c: f64,
    /// Largest acceleration, m/s2.
    limit: f64,
    /// Speed from which the limit is reached, m/s.
    saturated: f64,
    /// Lowest speed at the top that needs no overshoot, m/s.
    pub lowest: f64,
}

/// A side up to a certain top.
#[derive(Debug, Clone, Copy, Default)]
pub struct Climb {
    /// Peak acceleration, m/s2.
    peak: f64,
    /// Time at the peak, s.
    hold: f64,
}

impl Side {
    #[inline]
    pub fn new(v: f64, a: f64, limit: f64, (near, far): (f64, f64)) -> Self {
        let (sum, product) = (near + far, near * far);
        let r = 1.0 / product;
        let (x, y, k) = (far * r, near * r, sum * r);
        let gained = 0.5 * a * a * x;
        let base = v - gained;
        Self {
            a,
            base,
            skipped: a * x * (base + gained * (1.0 / 3.0)),
            inverse: (x, y),
            k,
            two_over_k: 2.0 * product / sum,
            c: x * x / 6.0 + y * (0.5 * x + y * (1.0 / 3.0)),
            limit,
            saturated: base + 0.5 * k * limit * limit,
            lowest: v + 0.5 * a * a * y,
        }
    }

    /// Peak acceleration for the top speed `w`, before the limit, m/s2.
    #[inline]
    fn peak(&self, w: f64) -> f64 {
        ((w - self.base).max(0.0) * self.two_over_k).sqrt().max(self.a)
    }

    /// Distance (m) with peak acceleration `p` below the limit.
    #[inline]
    fn free(&self, p: f64) -> f64 {
        p * (self.base * self.k + self.c * p * p) - self.skipped
    }

    /// Distance (m) and its derivative by `w` (s) above saturation.
    #[inline]
    fn held(&self, w: f64) -> (f64, f64) {
        let (p, hold) = (self.limit, (w - self.saturated) / self.limit);
        let rate = self.base + p * p * (0.5 * self.inverse.0 + self.inverse.1);
        (self.free(p) + hold * (rate + 0.5 * p * hold), (rate + p * hold) / p)
    }

    /// The way to the top at speed `w`.
    #[inline]
    fn climb(&self, w: f64) -> Climb {
        if w > self.saturated { Climb { peak: self.limit, hold: (w - self.saturated) / self.limit } } else { Climb { peak: self.peak(w), hold: 0.0 } }
    }

    /// Distance of a climb, m.
    #[inline]
    fn length(&self, climb: Climb) -> f64 {
        let Climb { peak, hold } = climb;
        let ramps = self.free(peak);
        if hold == 0.0 {
            return ramps;
        }
        ramps + hold * (self.base + peak * (peak * (0.5 * self.inverse.0 + self.inverse.1) + 0.5 * hold))
    }

    /// Distance up to the top speed `w` (m/s), m.
    pub fn distance(&self, w: f64) -> f64 {
        self.length(self.climb(w))
    }

    /// Durations (s): near ramp, hold, far ramp.
    #[inline]
    pub fn times(&self, climb: Climb) -> (f64, f64, f64) {
        ((climb.peak - self.a).max(0.0) * self.inverse.0, climb.hold, climb.peak * self.inverse.1)
    }
}

/// Both climbs and the cruise between them (s).
pub type Solved = ([Climb; 2], f64);

/// The fastest profile over `distance`, or `None` if the distance is too short.
#[inline]
pub fn solve(sides: &[Side; 2], distance: f64, speed: f64) -> Option<Solved> {
    let climbs = |w: f64| [sides[0].climb(w), sides[1].climb(w)];
    let total = |c: [Climb; 2]| sides[0].length(c[0]) + sides[1].length(c[1]);
    let low = sides[0].lowest.max(sides[1].lowest);
    let high = speed.max(low);
    let at_high = climbs(high);
    let d_high = total(at_high);
    if d_high <= distance {
        return Some((at_high, (distance - d_high) / high));
    }
    let [up, down] = sides;
    if up.base == 0.0 && down.base == 0.0 && high <= up.saturated && high <= down.saturated {
        let found = from_rest(up, down, distance + up.skipped + down.skipped);
        if found[0].peak >= up.a && found[1].peak >= down.a {
            return Some((found, 0.0));
        }
    }
    let at_low = climbs(low);
    let d_low = total(at_low);
    if d_low >= distance {
        // Rounding of the caller's own distance is not an infeasible problem.
        return (d_low - distance <= 1e-12 * d_low).then_some((at_low, 0.0));
    }
    Some((top(sides, distance, (low, high)), 0.0))
}

/// Both ends at a virtual rest and no limit of acceleration reached: the distance is a pure cubic.
#[inline]
fn from_rest(up: &Side, down: &Side, reach: f64) -> [Climb; 2] {
    let ratio = (up.k * 0.5 * down.two_over_k).sqrt();
    let cube = reach / (up.c + down.c * ratio * ratio * ratio);
    let q = cube_root::<3>(cube.max(0.0));
    [Climb { peak: q, hold: 0.0 }, Climb { peak: q * ratio, hold: 0.0 }]
}

/// The root of `D(w) = distance` in a bracket.
fn top(sides: &[Side; 2], distance: f64, (mut low, mut high): (f64, f64)) -> [Climb; 2] {
    for side in sides {
        let w = side.saturated;
        if w > low && w < high {
            let d = sides[0].length(sides[0].climb(w)) + sides[1].length(sides[1].climb(w));
            if d <= distance {
                low = w;
            } else {
                high = w;
            }
        }
    }
    let [up, down] = sides;
    match [low >= up.saturated, low >= down.saturated] {
        [true, true] => {
            let ((d0, r0), (d1, r1)) = (up.held(low), down.held(low));
            let (rest, slope) = (distance - d0 - d1, r0 + r1);
            let bend = 2.0 * (1.0 / up.limit + 1.0 / down.limit);
            let w = (low + 2.0 * rest / (slope + (slope * slope + bend * rest).max(0.0).sqrt())).clamp(low, high);
            [up.climb(w), down.climb(w)]
        }
        [true, false] => swap(newton(down, up, true, distance, (low, high))),
        [false, true] => newton(up, down, true, distance, (low, high)),
        // The side with the higher base has the smaller peak: in its peak the other one is smooth.
        [false, false] if up.base >= down.base => newton(up, down, false, distance, (low, high)),
        [false, false] => swap(newton(down, up, false, distance, (low, high))),
    }
}

fn swap([a, b]: [Climb; 2]) -> [Climb; 2] {
    [b, a]
}

/// Safeguarded Newton iteration in the peak acceleration `q` of the side `own`, which is below its limit.
#[inline]
fn newton(own: &Side, other: &Side, held: bool, distance: f64, (low, high): (f64, f64)) -> [Climb; 2] {
    let (mut lo, mut hi) = (own.peak(low), own.peak(high));
    let mut q = guess(own, other, held, distance).clamp(lo, hi);
    let linear = own.base * own.k;
    for _ in 0..100 {
        let w = own.base + 0.5 * own.k * q * q;
        let (d, slope) = if held {
            let (d, rate) = other.held(w);
            (d, rate * own.k * q)
        } else {
            let p = other.peak(w);
            let grow = if p > 0.0 { 0.5 * own.k * other.two_over_k * q / p } else { 1.0 };
            (other.free(p), (other.base * other.k + 3.0 * other.c * p * p) * grow)
        };
        let excess = d + own.free(q) - distance;
        if excess > 0.0 {
            hi = q;
        } else {
            lo = q;
        }
        let mut next = q - excess / (slope + linear + 3.0 * own.c * q * q);
        let inside = next >= lo && next <= hi;
        if !inside {
            next = f64::midpoint(lo, hi);
        }
        // The error after a step is of the order of the square of the step.
        let done = (next - q).abs() <= if inside { 3e-9 * q } else { 0.0 };
        q = next;
        if done {
            break;
        }
    }
    let w = (own.base + 0.5 * own.k * q * q).clamp(low, high);
    let over = if held {
        Climb { peak: other.limit, hold: ((w - other.saturated) / other.limit).max(0.0) }
    } else {
        Climb { peak: other.peak(w), hold: 0.0 }
    };
    [Climb { peak: q, hold: 0.0 }, over]
}

/// An upper estimate of the root: from the linear and from the cubic terms alone.
#[inline]
fn guess(own: &Side, other: &Side, held: bool, distance: f64) -> f64 {
    let reach = distance + own.skipped + other.skipped;
    let (mut linear, mut cubic) = (own.base * own.k, own.c);
    if !held {
        let ratio = (0.5 * own.k * other.two_over_k).sqrt();
        linear += other.base * other.k * ratio;
        cubic += other.c * ratio * ratio * ratio;
    }
    let by_cubic = cube_root::<1>((reach / cubic).max(0.0));
    if linear > 0.0 { by_cubic.min(reach / linear) } else { by_cubic }
}

/// Cube root of a positive number: an estimate from the exponent bits (within 6 %), then `N` steps of Halley's rule, each of which
/// cubes the relative error; three are exact to rounding. The library's `cbrt` takes as long as all the rest of a plan.
#[inline]
fn cube_root<const N: usize>(x: f64) -> f64 {
    let mut y = f64::from_bits(x.to_bits() / 3 + 0x2A9F_7893_782D_A1CE);
    for _ in 0..N {
        let cube = y * y * y;
        y *= (cube + 2.0 * x) / (2.0 * cube + x);
    }
    y
}

#[cfg(test)]
mod tests {
    use super::cube_root;

    #[test]
    fn cube_roots_are_exact_to_rounding() {
        for i in -280..=280 {
            for m in [1.0, 1.7, 2.5, 4.1, 7.9] {
                let x = m * 10f64.powi(i);
                assert!((cube_root::<3>(x) / x.cbrt() - 1.0).abs() < 1e-15, "{x}");
                assert!((cube_root::<1>(x) / x.cbrt() - 1.0).abs() < 1e-3, "{x}");
            }
        }
    }
}
