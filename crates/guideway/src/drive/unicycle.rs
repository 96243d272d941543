//! A unicycle (differential drive) with first-order actuator lags, limits, and noisy estimates.
//!
//! Source: kinematic unicycle with first-order lags of both speeds; Gaussian noise, and a slow drift of the estimated pose (a first-order Gauss-Markov
//! process). The arc is integrated exactly per sub-step.

use super::{Command, Motion, Observation, Plant, Robot, arc};
use crate::error::PlanError;
use crate::world::shape::wrap;
use rand::RngExt;
use rand_chacha::ChaCha8Rng;
use rand_chacha::rand_core::SeedableRng;
use serde::{Deserialize, Serialize};

/// Integration step, s.
const SUBSTEP: f64 = 0.001;
/// Time in which a drift of the localisation is forgotten, s.
const DRIFTING: f64 = 20.0;

/// Parameters of the plant; each 0 switches its effect off.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct Unicycle {
    /// Time constant of the speed, s.
    pub lag_speed: f64,
    /// Time constant of the turn rate, s.
    pub lag_turn: f64,
    /// Standard deviation of each observed coordinate, m.
    pub noise_position: f64,
    /// Standard deviation of the observed heading, rad.
    pub noise_heading: f64,
    /// Relative error of both observed speeds, 1.
    pub odometry_scale: f64,
    /// Standard deviation of the slow drift of each observed coordinate, m.
    pub drift_position: f64,
    /// Standard deviation of the slow drift of the observed heading, rad.
    pub drift_heading: f64,
}

impl Default for Unicycle {
    fn default() -> Self {
        Self { lag_speed: 0.08, lag_turn: 0.06, noise_position: 0.005, noise_heading: 0.2_f64.to_radians(), odometry_scale: 0.005, ..Self::ideal() }
    }
}

impl Unicycle {
    /// Without lag and noise; the limits of the robot still hold.
    pub fn ideal() -> Self {
        Self { lag_speed: 0.0, lag_turn: 0.0, noise_position: 0.0, noise_heading: 0.0, odometry_scale: 0.0, drift_position: 0.0, drift_heading: 0.0 }
    }

    /// Checks the parameters.
    /// # Errors
    /// [`PlanError::BadParameter`] names the first out of range.
    pub fn validated(self) -> Result<Self, PlanError> {
        let named = [
            ("lag_speed", self.lag_speed, 10.0),
            ("lag_turn", self.lag_turn, 10.0),
            ("noise_position", self.noise_position, 10.0),
            ("noise_heading", self.noise_heading, 3.2),
            ("odometry_scale", self.odometry_scale, 0.5),
            ("drift_position", self.drift_position, 10.0),
            ("drift_heading", self.drift_heading, 3.2),
        ];
        match named.into_iter().find(|(_, v, top)| !(0.0..=*top).contains(v)) {
            Some((name, value, top)) => Err(PlanError::bad(format!("plant.{name}"), value, format!("0 to {top}"))),
            None => Ok(self),
        }
    }

    /// The plant at rest at `pose`; its noise depends on `seed` only.
    pub fn place(self, robot: &Robot, pose: [f64; 3], seed: u64) -> UnicyclePlant {
        let mut rng = ChaCha8Rng::seed_from_u64(seed);
        rng.set_stream(0x706c_616e_7400);
        UnicyclePlant { parameters: self, robot: robot.clone(), motion: Motion { pose, v: 0.0, w: 0.0 }, time: 0.0, drift: ([0.0; 3], 0.0), rng }
    }
}

/// A unicycle in motion.
#[derive(Debug, Clone)]
pub struct UnicyclePlant {
    parameters: Unicycle,
    robot: Robot,
    motion: Motion,
    time: f64,
    /// Drift of the estimated pose in standard deviations, and when, s.
    drift: ([f64; 3], f64),
    rng: ChaCha8Rng,
}

impl UnicyclePlant {
    /// One standard normal draw (Box and Muller).
    fn normal(&mut self) -> f64 {
        let (a, b): (f64, f64) = (self.rng.random(), self.rng.random());
        (-2.0 * (1.0 - a).ln()).sqrt() * (std::f64::consts::TAU * b).cos()
    }

    /// The drift of the estimated pose now, m, m, rad.
    fn drifted(&mut self) -> [f64; 3] {
        let p = self.parameters;
        if p.drift_position == 0.0 && p.drift_heading == 0.0 {
            return [0.0; 3];
        }
        let keep = (-(self.time - self.drift.1) / DRIFTING).exp();
        let fresh = (1.0 - keep * keep).sqrt();
        self.drift = (self.drift.0.map(|d| keep * d + fresh * self.normal()), self.time);
        let [x, y, yaw] = self.drift.0;
        [p.drift_position * x, p.drift_position * y, p.drift_heading * yaw]
    }

    fn substep(&mut self, u: Command, h: f64) {
        let (m, r) = (self.motion, &self.robot);
        let v = lagged([m.v, u.v], self.parameters.lag_speed, [r.acceleration, r.deceleration], h);
        let w = lagged([m.w, u.w], self.parameters.lag_turn, [r.turn_acceleration; 2], h);
        let [x, y, yaw] = arc(m.pose, 0.5 * (m.v + v), 0.5 * (m.w + w), h);
        self.motion = Motion { pose: [x, y, wrap(yaw)], v, w };
    }
}

/// The next value of an actuator that follows its target with time constant `lag` (s) and the rate limits [away from zero, towards zero].
fn lagged([x, target]: [f64; 2], lag: f64, limits: [f64; 2], h: f64) -> f64 {
    let wanted = if lag > 0.0 { (target - x) * -(-h / lag).exp_m1() } else { target - x };
    let towards_zero = x * wanted < 0.0;
    let limit = limits[usize::from(towards_zero)] * h;
    x + wanted.clamp(-limit, limit)
}

impl Plant for UnicyclePlant {
    fn observe(&mut self) -> Observation {
        let (p, m) = (self.parameters, self.motion);
        let noise = [p.noise_position * self.normal(), p.noise_position * self.normal(), p.noise_heading * self.normal()];
        let drift = self.drifted();
        let pose = [m.pose[0] + noise[0] + drift[0], m.pose[1] + noise[1] + drift[1], wrap(m.pose[2] + noise[2] + drift[2])];
        let scale = 1.0 + p.odometry_scale;
        Observation::new(self.time, pose, m.v * scale, m.w * scale)
    }

    fn step(&mut self, u: Command, dt: f64) {
        let r = &self.robot;
        let finite = |x: f64, top: f64| if x.is_finite() { x.clamp(-top, top) } else { 0.0 };
        let u = Command { v: finite(u.v, r.speed), w: finite(u.w, r.turn_rate) };
        let n = (dt / SUBSTEP).ceil().max(1.0);
        for _ in 0..n as u64 {
            self.substep(u, dt / n);
        }
        self.time += dt;
    }

    fn motion(&self) -> Motion {
        self.motion
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::world::Footprint;

    fn robot() -> Robot {
        Robot {
            footprint: Footprint::Disc(0.2),
            speed: 2.0,
            acceleration: 1.0,
            deceleration: 0.5,
            jerk: 10.0,
            turn_rate: 2.0,
            turn_acceleration: 4.0,
        }
    }

    #[test]
    fn a_straight_run_follows_the_closed_form_of_limited_acceleration() {
        let mut plant = Unicycle::ideal().place(&robot(), [1.0, 2.0, 0.0], 1);
        (0..100).for_each(|_| plant.step(Command { v: 2.0, w: 0.0 }, 0.02));
        let m = plant.motion();
        assert!((m.v - 2.0).abs() < 1e-9 && (m.pose[0] - 3.0).abs() < 1e-9 && (m.pose[1] - 2.0).abs() < 1e-12, "{m:?}");
        (0..200).for_each(|_| plant.step(Command::default(), 0.02));
        let m = plant.motion();
        assert!(m.v.abs() < 1e-9 && (m.pose[0] - 7.0).abs() < 1e-9, "braking at half the rate takes 4 s and 4 m: {m:?}");
    }

    #[test]
    fn constant_speeds_draw_the_exact_circle() {
        let mut plant = Unicycle::ideal().place(&robot(), [0.0, 0.0, 0.0], 1);
        (0..100).for_each(|_| plant.step(Command { v: 1.0, w: 0.5 }, 0.02));
        let from = plant.motion();
        (0..100).for_each(|_| plant.step(Command { v: 1.0, w: 0.5 }, 0.02));
        let to = plant.motion();
        let exact = arc(from.pose, 1.0, 0.5, 2.0);
        assert!((0..2).all(|k| (to.pose[k] - exact[k]).abs() < 1e-9), "{:?} {exact:?}", to.pose);
        let radius = 2.0;
        let center = [from.pose[0] - radius * from.pose[2].sin(), from.pose[1] + radius * from.pose[2].cos()];
        assert!(((to.pose[0] - center[0]).hypot(to.pose[1] - center[1]) - radius).abs() < 1e-9);
    }

    #[test]
    fn a_lag_answers_a_step_exponentially() {
        let fast = Robot { acceleration: 1e3, deceleration: 1e3, turn_acceleration: 1e3, ..robot() };
        let lags = Unicycle { lag_speed: 0.08, lag_turn: 0.06, ..Unicycle::ideal() };
        let mut plant = lags.place(&fast, [0.0; 3], 1);
        (0..5).for_each(|_| plant.step(Command { v: 1.0, w: 1.0 }, 0.02));
        let m = plant.motion();
        assert!((m.v - (1.0 - (-0.1_f64 / 0.08).exp())).abs() < 1e-9 && (m.w - (1.0 - (-0.1_f64 / 0.06).exp())).abs() < 1e-9, "{m:?}");
    }

    #[test]
    fn noise_has_its_size_and_comes_from_the_seed() {
        let mut plant = Unicycle::default().place(&robot(), [0.0; 3], 5);
        let seen: Vec<Observation> = (0..4000).map(|_| plant.observe()).collect();
        let deviation = |k: usize| (seen.iter().map(|o| o.pose[k] * o.pose[k]).sum::<f64>() / 4000.0).sqrt();
        assert!((deviation(0) / 0.005 - 1.0).abs() < 0.05 && (deviation(2).to_degrees() / 0.2 - 1.0).abs() < 0.05);
        let again = Unicycle::default().place(&robot(), [0.0; 3], 5).observe();
        assert_eq!(again.pose, seen[0].pose);
        assert_ne!(Unicycle::default().place(&robot(), [0.0; 3], 6).observe().pose, seen[0].pose);
    }

    #[test]
    fn drift_is_slow_and_has_its_size() {
        let plant = Unicycle { drift_position: 0.1, ..Unicycle::ideal() };
        let mut plant = plant.place(&robot(), [0.0; 3], 5);
        let seen: Vec<f64> = (0..400_000)
            .map(|_| {
                plant.time += 0.05;
                plant.observe().pose[0]
            })
            .collect();
        let mean = |all: &mut dyn Iterator<Item = f64>| all.sum::<f64>() / 4e5;
        let (size, step) = (mean(&mut seen.iter().map(|x| x * x)).sqrt(), mean(&mut seen.windows(2).map(|w| (w[1] - w[0]).powi(2))).sqrt());
        assert!((size / 0.1 - 1.0).abs() < 0.1 && step < 0.01, "{size} {step}");
    }

    #[test]
    fn commands_that_are_no_numbers_stop_the_base() {
        let mut plant = Unicycle::default().place(&robot(), [0.0; 3], 5);
        plant.step(Command { v: f64::NAN, w: f64::INFINITY }, 0.02);
        assert_eq!((plant.motion().v, plant.motion().w), (0.0, 0.0));
        assert!(Unicycle { lag_speed: f64::NAN, ..Unicycle::default() }.validated().is_err());
    }
}
