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
    /// Cubic coefficient of the distance over `p`.
    c: f64,
    /// Largest acceleration, m/s2.
    limit: f64,
    /// Speed from which the limit is reached, m/s.
    saturated: f64,
    /// Lowest speed at the top that needs no overshoot, m/s.
    lowest: f64,
}

impl Side {
    #[inline]
    pub fn new(v: f64, a: f64, limit: f64, (near, far): (f64, f64)) -> Self {
        let (x, y) = (1.0 / near, 1.0 / far);
        let (k, base) = (x + y, v - 0.5 * a * a * x);
        Self {
            a,
            base,
            skipped: a * x * (base + a * a * x / 6.0),
            inverse: (x, y),
            k,
            c: x * x / 6.0 + 0.5 * x * y + y * y / 3.0,
            limit,
            saturated: base + 0.5 * k * limit * limit,
            lowest: v + 0.5 * a * a * y,
        }
    }

    /// Peak acceleration for the top speed `w`, before the limit, m/s2.
    #[inline]
    fn peak(&self, w: f64) -> f64 {
        (2.0 * (w - self.base).max(0.0) / self.k).sqrt().max(self.a)
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

    /// Distance to the top at speed `w`, m.
    #[inline]
    pub fn distance(&self, w: f64) -> f64 {
        if w > self.saturated { self.held(w).0 } else { self.free(self.peak(w)) }
    }

    /// Durations (s): near ramp, hold, far ramp.
    #[inline]
    pub fn times(&self, w: f64) -> (f64, f64, f64) {
        if w > self.saturated {
            return ((self.limit - self.a).max(0.0) * self.inverse.0, (w - self.saturated) / self.limit, self.limit * self.inverse.1);
        }
        let p = self.peak(w);
        ((p - self.a) * self.inverse.0, 0.0, p * self.inverse.1)
    }
}

/// Top speed (m/s) and cruise time (s) of the fastest profile over `distance`, or `None` if the distance is too short.
#[inline]
pub fn solve(sides: &[Side; 2], distance: f64, speed: f64) -> Option<(f64, f64)> {
    let total = |w: f64| sides[0].distance(w) + sides[1].distance(w);
    let low = sides[0].lowest.max(sides[1].lowest);
    let high = speed.max(low);
    let d_high = total(high);
    if d_high <= distance {
        return Some((high, (distance - d_high) / high));
    }
    let d_low = total(low);
    if d_low >= distance {
        // Rounding of the caller's own distance is not an infeasible problem.
        return (d_low - distance <= 1e-12 * d_low).then_some((low, 0.0));
    }
    Some((top(sides, distance, (low, high)), 0.0))
}

/// The root of `D(w) = distance` in a bracket.
fn top(sides: &[Side; 2], distance: f64, (mut low, mut high): (f64, f64)) -> f64 {
    let total = |w: f64| sides[0].distance(w) + sides[1].distance(w);
    for side in sides {
        let w = side.saturated;
        if w > low && w < high {
            if total(w) <= distance { low = w } else { high = w }
        }
    }
    let held = [low >= sides[0].saturated, low >= sides[1].saturated];
    match held {
        [true, true] => {
            let ((d0, r0), (d1, r1)) = (sides[0].held(low), sides[1].held(low));
            let (rest, slope) = (distance - d0 - d1, r0 + r1);
            let bend = 2.0 * (1.0 / sides[0].limit + 1.0 / sides[1].limit);
            (low + 2.0 * rest / (slope + (slope * slope + bend * rest).max(0.0).sqrt())).clamp(low, high)
        }
        [true, false] => newton(&sides[1], &sides[0], true, distance, (low, high)),
        [false, true] => newton(&sides[0], &sides[1], true, distance, (low, high)),
        // The side with the higher base has the smaller peak: in its peak the other one is smooth.
        [false, false] if sides[0].base >= sides[1].base => newton(&sides[0], &sides[1], false, distance, (low, high)),
        [false, false] => newton(&sides[1], &sides[0], false, distance, (low, high)),
    }
}

/// Safeguarded Newton iteration in the peak acceleration `q` of the side `own`, which is below its limit.
fn newton(own: &Side, other: &Side, held: bool, distance: f64, (low, high): (f64, f64)) -> f64 {
    let (mut lo, mut hi) = (own.peak(low), own.peak(high));
    let mut q = guess(own, other, held, distance).clamp(lo, hi);
    for _ in 0..100 {
        let w = own.base + 0.5 * own.k * q * q;
        let (d, slope) = if held {
            let (d, rate) = other.held(w);
            (d, rate * own.k * q)
        } else {
            let p = other.peak(w);
            let grow = if p > 0.0 { own.k * q / (other.k * p) } else { 1.0 };
            (other.free(p), (other.base * other.k + 3.0 * other.c * p * p) * grow)
        };
        let excess = d + own.free(q) - distance;
        if excess > 0.0 {
            hi = q;
        } else {
            lo = q;
        }
        let step = excess / (slope + own.base * own.k + 3.0 * own.c * q * q);
        let mut next = q - step;
        if !(next >= lo && next <= hi) {
            next = f64::midpoint(lo, hi);
        }
        let done = (next - q).abs() <= 1e-15 * q || excess == 0.0;
        q = next;
        if done {
            break;
        }
    }
    (own.base + 0.5 * own.k * q * q).clamp(low, high)
}

/// An upper estimate of the root: from the linear and from the cubic terms alone.
#[inline]
fn guess(own: &Side, other: &Side, held: bool, distance: f64) -> f64 {
    let reach = distance + own.skipped + other.skipped;
    let (mut linear, mut cubic) = (own.base * own.k, own.c);
    if !held {
        let ratio = (own.k / other.k).sqrt();
        linear += other.base * other.k * ratio;
        cubic += other.c * ratio * ratio * ratio;
    }
    let by_cubic = (reach / cubic).cbrt();
    if linear > 0.0 { by_cubic.min(reach / linear) } else { by_cubic }
}
