//! Back into the limits, as fast as they allow, from a start outside them.
//!
//! A start is outside if its acceleration or its speed is, or if its speed will inevitably be when the acceleration has come to zero.
//! The acceleration is brought back at the jerk limit first; a speed outside is brought back with the full opposite acceleration
//! until it meets its limit, unless the opposite limit would be overstepped after that.

use super::AxisLimits;
use super::leg::Shape;
use super::line::settled;
use crate::timing::scurve::advance;

/// Limits as the brake sees them, perhaps mirrored.
#[derive(Clone, Copy)]
struct Walls {
    speed: (f64, f64),
    acceleration: (f64, f64),
    jerk: f64,
}

impl Walls {
    fn flipped(self) -> Self {
        let ((v0, v1), (a0, a1)) = (self.speed, self.acceleration);
        Self { speed: (-v1, -v0), acceleration: (-a1, -a0), jerk: self.jerk }
    }
}

/// The phases that bring (position, speed, acceleration) into the limits.
pub(super) fn brake((v, a): (f64, f64), limits: &AxisLimits, bounded: bool) -> Shape {
    let speed = if bounded { limits.velocity } else { (f64::NEG_INFINITY, f64::INFINITY) };
    let walls = Walls { speed, acceleration: limits.acceleration, jerk: limits.jerk };
    let slack = |x: f64| 1e-12 * x.abs();
    let rest = settled((v, a), limits.jerk);
    let fast = |x: f64, wall: f64| x > wall + slack(wall);
    let over = |v: f64, a: f64, rest: f64, w: &Walls| {
        if fast(a, w.acceleration.1) {
            return Some(if fast(rest, w.speed.1) { Way::Speed } else { Way::Acceleration });
        }
        (a >= w.acceleration.0 - slack(w.acceleration.0) && (fast(rest, w.speed.1) || (fast(v, w.speed.1) && rest > w.speed.0))).then_some(Way::Speed)
    };
    if let Some(way) = over(v, a, rest, &walls) {
        return way.shape((v, a), walls);
    }
    match over(-v, -a, -rest, &walls.flipped()) {
        Some(way) => way.shape((-v, -a), walls.flipped()).flipped(),
        None => Shape::new(),
    }
}

/// What is too high.
#[derive(Clone, Copy)]
enum Way {
    Acceleration,
    Speed,
}

impl Way {
    fn shape(self, (v, a): (f64, f64), walls: Walls) -> Shape {
        let mut shape = Shape::new();
        match self {
            Self::Speed => slow_down((v, a), walls, &mut shape),
            Self::Acceleration => {
                let t = (a - walls.acceleration.1) / walls.jerk;
                shape.push(t, -walls.jerk);
                let (_, v, _) = advance((0.0, v, a), -walls.jerk, t);
                if v < walls.speed.0 {
                    let a = walls.acceleration.1;
                    hold((-v, -a), walls.flipped(), &mut shape, 1.0);
                }
            }
        }
        shape
    }
}

/// Full deceleration until the speed is back at its limit or would later fall below the lower one.
fn slow_down((v, a): (f64, f64), walls: Walls, shape: &mut Shape) {
    let Walls { speed: (low, high), acceleration: (least, _), jerk } = walls;
    let back = (a + (a * a + 2.0 * jerk * (v - high)).max(0.0).sqrt()) / jerk;
    let turn = (a + (0.5 * a * a + jerk * (v - low)).max(0.0).sqrt()) / jerk;
    let full = (a - least) / jerk;
    let t = back.min(turn).min(full).max(0.0);
    shape.push(t, -jerk);
    let (_, v, a) = advance((0.0, v, a), -jerk, t);
    if full < back.min(turn) {
        hold((v, least), walls, shape, -1.0);
    } else if turn < back && a < 0.0 {
        shape.push(-a / jerk, jerk);
    }
}

/// Keeps the deceleration `a < 0` until the speed is back, or would later fall below the lower limit: then it is released.
/// `sign` is that of the deceleration where the caller stands.
fn hold((v, a): (f64, f64), walls: Walls, shape: &mut Shape, sign: f64) {
    let Walls { speed: (low, high), jerk, .. } = walls;
    let back = (v - high) / -a;
    let turn = (v - a * a / (2.0 * jerk) - low) / -a;
    shape.push(back.min(turn).max(0.0), 0.0);
    if turn < back {
        shape.push(-a / jerk, -sign * jerk);
    }
}
