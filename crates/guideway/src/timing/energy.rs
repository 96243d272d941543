//! Energy of a motion: rolling, accelerating and turning, without regeneration.

use super::trajectory::{Piece, State, Trajectory};

/// Time between samples, s.
const STEP: f64 = 0.01;
/// Gravity, m/s2.
const GRAVITY: f64 = 9.81;

/// A nominal mobile base, our own model (`metrics` 5.2) with turning added; good for comparing motions with each other, not for sizing a battery.
///
/// `E = integral of max(0, P) / efficiency + copper a^2 dt` with `P = (rolling m g + m a) v + I w dw/dt`: what braking and slowing turns give back is lost, so
/// every stop costs `m v^2 / 2` and every turn `I w^2 / 2`.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Drive {
    /// Robot and load, kg.
    pub mass: f64,
    /// Moment of inertia about the vertical axis, kg m2: a box of 0.6 m x 0.5 m.
    pub inertia: f64,
    /// Rolling resistance, share of the weight.
    pub rolling: f64,
    /// Efficiency of the drive, 0 to 1.
    pub efficiency: f64,
    /// Copper loss, W/(m/s2)2.
    pub copper: f64,
}

impl Default for Drive {
    fn default() -> Self {
        Self { mass: 40.0, inertia: 40.0 * (0.6 * 0.6 + 0.5 * 0.5) / 12.0, rolling: 0.015, efficiency: 0.75, copper: 1.2 }
    }
}

impl Drive {
    /// Energy that the motion takes, J. Speeds are sampled every 0.01 s and at the ends of pieces; the energies stored in motion and turning are exact there.
    pub fn energy(&self, motion: &Trajectory) -> f64 {
        motion.pieces.iter().fold(0.0, |sum, piece| sum + self.piece(motion, piece)) // an empty sum would be -0
    }

    fn piece(&self, motion: &Trajectory, piece: &Piece) -> f64 {
        let (from, duration) = (piece.start(), piece.duration());
        let n = (duration / STEP).ceil().max(1.0) as u64;
        // At its very end the state is already that of the next piece.
        let at = |k: u64| motion.at(from + duration * if k == n { 1.0 - 1e-9 } else { k as f64 / n as f64 });
        let (mut before, mut sum) = (at(0), 0.0);
        for k in 1..=n {
            let now = at(k);
            sum += self.step(&before, &now, duration / n as f64);
            before = now;
        }
        sum
    }

    /// Energy between two states `dt` (s) apart.
    fn step(&self, a: &State, b: &State, dt: f64) -> f64 {
        let stored = |s: &State| 0.5 * (self.mass * s.speed * s.speed + self.inertia * s.turn_rate * s.turn_rate);
        let rolled = self.rolling * self.mass * GRAVITY * (b.s - a.s);
        let squares = (a.acceleration * a.acceleration + a.acceleration * b.acceleration + b.acceleration * b.acceleration) / 3.0;
        (rolled + stored(b) - stored(a)).max(0.0) / self.efficiency + self.copper * squares * dt
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::context::Context;
    use crate::path::Path;
    use crate::query::Limits;
    use crate::timing::{TimingOptions, time};

    fn energy(points: &[[f64; 2]], limits: &Limits) -> f64 {
        Drive::default().energy(&time(&Path::polyline(points), limits, &TimingOptions::default(), &mut Context::new(0)).unwrap())
    }

    #[test]
    fn a_straight_drive_costs_what_the_integral_says() {
        // Nearly a trapezoid of speed: to 1 m/s at 0.5 m/s2, and back. Rolling counts while speeding up and cruising; braking gives more than rolling takes.
        let limits = Limits { jerk: 1e5, ..Limits::default() };
        let (weight, length) = (0.015 * 40.0 * 9.81, 10.0);
        let by_hand = (weight * (length - 1.0) + 0.5 * 40.0) / 0.75 + 1.2 * 0.25 * 4.0;
        let found = energy(&[[0.0, 0.0], [length, 0.0]], &limits);
        assert!((found - by_hand).abs() < 1e-3 * by_hand, "{found} {by_hand}");
    }

    #[test]
    fn a_corner_costs_a_stop_and_a_turn() {
        let limits = Limits { jerk: 1e5, ..Limits::default() };
        let (straight, bent) = (energy(&[[0.0, 0.0], [20.0, 0.0]], &limits), energy(&[[0.0, 0.0], [10.0, 0.0], [10.0, 10.0]], &limits));
        // Once more to 1 m/s and braking, during which nothing rolls on energy, and once to 1 rad/s.
        let inertia = Drive::default().inertia;
        let by_hand = (0.5 * 40.0 + 0.5 * inertia - 0.015 * 40.0 * 9.81) / 0.75 + 1.2 * 0.25 * 4.0;
        assert!((bent - straight - by_hand).abs() < 1e-2 * by_hand, "{} {by_hand}", bent - straight);
    }

    #[test]
    fn no_motion_costs_nothing() {
        assert!(energy(&[[1.0, 1.0]], &Limits::default()).is_sign_positive());
        assert_eq!(energy(&[[1.0, 1.0]], &Limits::default()), 0.0);
    }
}
