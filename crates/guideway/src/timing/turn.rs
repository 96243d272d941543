//! Turns in place: rest to rest, limited rate and acceleration, no jerk limit (the wheels are unloaded by any motion along the path then).

use crate::query::Limits;

/// Turn rate used where the limits name none, rad/s.
pub const DEFAULT_TURN_RATE: f64 = 1.0;
/// Turn acceleration used where the limits name none, rad/s2.
pub const DEFAULT_TURN_ACCELERATION: f64 = 2.0;

/// Turns below this are rounding, rad.
pub(super) const SAME_HEADING: f64 = 1e-9;

/// Rate (rad/s) and acceleration (rad/s2) that bound a turn in place.
pub(super) fn bounds(limits: &Limits) -> (f64, f64) {
    (limits.turn_rate.unwrap_or(DEFAULT_TURN_RATE), limits.turn_acceleration.unwrap_or(DEFAULT_TURN_ACCELERATION))
}

/// Time for a turn by `angle` (rad, any sign), s.
pub fn turn_time(angle: f64, limits: &Limits) -> f64 {
    let (rate, acceleration) = bounds(limits);
    let angle = angle.abs();
    if angle * acceleration <= rate * rate { 2.0 * (angle / acceleration).sqrt() } else { angle / rate + rate / acceleration }
}

/// Angle turned (rad) and rate (rad/s) after `t` of `duration` seconds of a turn by `angle`: a trapezoid of the rate with the limits' acceleration.
pub(super) fn turned(angle: f64, duration: f64, t: f64, limits: &Limits) -> (f64, f64) {
    let (t, total) = (t.clamp(0.0, duration), angle.abs());
    // The ramps of the trapezoid follow from angle and duration: angle = a r (duration - r).
    let acceleration = bounds(limits).1;
    let ramp = 0.5 * (duration - (duration * duration - 4.0 * total / acceleration).max(0.0).sqrt());
    if ramp <= 0.0 {
        return (0.0, 0.0);
    }
    let top = total / (duration - ramp);
    let eased = |t: f64| 0.5 * top * t * t / ramp;
    let (done, rate) = if t < ramp {
        (eased(t), top * t / ramp)
    } else if t <= duration - ramp {
        (top * (t - 0.5 * ramp), top)
    } else {
        (total - eased(duration - t), top * (duration - t) / ramp)
    };
    (done.copysign(angle), rate.copysign(angle))
}
