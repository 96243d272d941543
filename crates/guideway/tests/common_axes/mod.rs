//! Random problems of several axes and an independent check of motions; nothing here calls the planner's own arithmetic.

use guideway::timing::axes::{Axis, AxisGoal, AxisLimits, AxisMotion, AxisState, Input, Sync, plan};
use rand::RngExt;
use rand_chacha::ChaCha8Rng;
use rand_chacha::rand_core::SeedableRng;

/// Log-uniform in a range.
fn spread(rng: &mut ChaCha8Rng, low: f64, high: f64) -> f64 {
    low * (high / low).powf(rng.random::<f64>())
}

fn limits(rng: &mut ChaCha8Rng) -> AxisLimits {
    let mut draw = || spread(rng, 1e-2, 1e2);
    let (v, a, jerk) = (draw(), draw(), draw());
    let (low_v, low_a) = (draw(), draw());
    if rng.random::<f64>() < 0.3 {
        return AxisLimits::symmetric(v, a, jerk);
    }
    AxisLimits { velocity: (-low_v, v), acceleration: (-low_a, a), jerk }
}

/// Velocity and acceleration that limits allow, for a start (`sign` 1) or a goal (-1): at rest, at a limit or anywhere.
fn boundary(rng: &mut ChaCha8Rng, limits: &AxisLimits, sign: f64) -> (f64, f64) {
    let (low, high) = limits.velocity;
    let v = match rng.random_range(0..5) {
        0 => 0.0,
        1 => high,
        2 => low,
        _ => low + (high - low) * rng.random::<f64>(),
    };
    // An acceleration away from zero must not lead beyond the velocity limit by the time it has gone.
    let up = (2.0 * limits.jerk * (high - v)).max(0.0).sqrt();
    let down = (2.0 * limits.jerk * (v - low)).max(0.0).sqrt();
    let (least, most) = limits.acceleration;
    let (below, above) = if sign > 0.0 { (down, up) } else { (up, down) };
    let range = (least.max(-below), most.min(above));
    let a = match rng.random_range(0..5) {
        0 | 1 => 0.0,
        2 => range.1 * (1.0 - 1e-12),
        _ => range.0 + (range.1 - range.0) * rng.random::<f64>(),
    };
    (v, a)
}

/// One axis over wide limits.
pub fn axis(rng: &mut ChaCha8Rng) -> Axis {
    let limits = limits(rng);
    let (v0, a0) = boundary(rng, &limits, 1.0);
    let (v1, a1) = boundary(rng, &limits, -1.0);
    let p0 = rng.random_range(-1.0..1.0);
    let p1 = match rng.random_range(0..8) {
        0 => p0,
        1 => p0 + 1e-9 * rng.random::<f64>(),
        _ => p0 + spread(rng, 1e-4, 1e4) * if rng.random::<bool>() { 1.0 } else { -1.0 },
    };
    Axis {
        start: AxisState { position: p0, velocity: v0, acceleration: a0 },
        goal: AxisGoal { position: Some(p1), velocity: v1, acceleration: a1 },
        limits,
        enabled: true,
    }
}

/// One axis that starts anywhere, mostly outside its limits; and its limits widened to what a brake cannot avoid.
fn wild(rng: &mut ChaCha8Rng) -> (Axis, AxisLimits) {
    let mut axis = axis(rng);
    let AxisLimits { velocity, acceleration, jerk } = axis.limits;
    let (v, a) = (rng.random_range(-2.0..2.0) * velocity.1, rng.random_range(-3.0..3.0) * acceleration.1);
    // Far outside, but not by orders of magnitude: rounding is relative to the fastest velocity.
    let jerk = jerk.max(0.1 * a * a / velocity.1);
    axis.limits.jerk = jerk;
    (axis.start.velocity, axis.start.acceleration) = (v, a);
    let rest = v + a * a.abs() / (2.0 * jerk);
    let wide = |(low, high): (f64, f64), x: f64, y: f64| (low.min(x).min(y), high.max(x).max(y));
    (axis, AxisLimits { velocity: wide(velocity, v, rest), acceleration: wide(acceleration, a, a), jerk })
}

/// Plans from random starts outside the limits.
pub fn outside(count: usize, seed: u64) {
    let mut rng = ChaCha8Rng::seed_from_u64(seed);
    for n in 0..count {
        let (axis, widened) = wild(&mut rng);
        let input = Input { axes: vec![axis], minimum_duration: spread(&mut rng, 1e-3, 1e2), ..Input::default() };
        let motion = plan(&input).unwrap_or_else(|e| panic!("{n}: {e}\n{axis:?}"));
        let (off, excess) = errors(&Axis { limits: widened, ..axis }, &motion.axes[0]);
        assert!(off <= 1e-9 && excess <= 1e-9, "{n}: off {off:e}, excess {excess:e}\n{axis:?}\n{motion:?}");
    }
}

/// Some axes, some way to go together.
pub fn problem(rng: &mut ChaCha8Rng) -> Input {
    let count = rng.random_range(1..5);
    let mut axes: Vec<Axis> = (0..count).map(|_| axis(rng)).collect();
    if rng.random::<f64>() < 0.1 {
        for axis in &mut axes {
            axis.goal.position = None;
        }
    }
    let sync = if rng.random::<f64>() < 0.1 { Sync::None } else { Sync::Time };
    let minimum_duration = if rng.random::<f64>() < 0.2 { spread(rng, 1e-2, 1e4) } else { 0.0 };
    let cycle = (rng.random::<f64>() < 0.1).then(|| spread(rng, 1e-3, 1e-1));
    Input { axes, sync, minimum_duration, cycle }
}

/// Largest error of the ends and jumps between pieces (relative to the way and the speeds on it) and excess over limits (relative to them).
pub fn errors(axis: &Axis, motion: &AxisMotion) -> (f64, f64) {
    let (mut p, mut v, mut a) = (axis.start.position, axis.start.velocity, axis.start.acceleration);
    let (mut way, mut fast, mut strong) = (p.abs(), v.abs(), a.abs());
    let mut excess: f64 = 0.0;
    let mut clock = 0.0;
    let mut over = |x: f64, (low, high): (f64, f64)| excess = excess.max((x - high) / high).max((low - x) / -low);
    let mut jumps = [0.0f64; 3];
    for piece in &motion.pieces {
        let (t, j, at) = (piece.duration, piece.jerk, piece.start);
        assert!(t > 0.0 && j.is_finite(), "{piece:?}");
        for (jump, gap) in jumps.iter_mut().zip([at.position - p, at.velocity - v, at.acceleration - a]) {
            *jump += gap.abs();
        }
        (p, v, a) = (at.position, at.velocity, at.acceleration);
        over(j, (-axis.limits.jerk, axis.limits.jerk));
        let (v1, a1) = (v + a * t + j * t * t / 2.0, a + j * t);
        let mut turned = v1;
        if a * a1 < 0.0 {
            turned = v - a * a / (2.0 * j);
        }
        let bounded = axis.goal.position.is_some();
        for speed in [v1, turned].into_iter().filter(|_| bounded) {
            over(speed, axis.limits.velocity);
        }
        over(a1, axis.limits.acceleration);
        p += v * t + a * t * t / 2.0 + j * t * t * t / 6.0;
        way += v.abs().max(v1.abs()).max(turned.abs()) * t;
        (v, a) = (v1, a1);
        fast = fast.max(v.abs()).max(turned.abs());
        strong = strong.max(a.abs());
        clock += t;
    }
    let mut off: f64 = (jumps[1] + (v - axis.goal.velocity).abs()) / fast.max(1e-6);
    off = off.max((jumps[2] + (a - axis.goal.acceleration).abs()) / strong.max(1e-6));
    if let Some(goal) = axis.goal.position {
        off = off.max((jumps[0] + (p - goal).abs()) / way.max(goal.abs()).max(1e-6));
    }
    off = off.max((clock - motion.duration).abs() / motion.duration.max(1e-6));
    (off, excess)
}

/// Plans random problems, each of them feasible, and checks every motion.
pub fn random(count: usize, seed: u64) {
    let mut rng = ChaCha8Rng::seed_from_u64(seed);
    let (mut worst_off, mut worst_excess) = (0.0f64, 0.0f64);
    for n in 0..count {
        let input = problem(&mut rng);
        let motion = match plan(&input) {
            Ok(motion) => motion,
            Err(e) => panic!("{n}: {e}\n{input:?}"),
        };
        for (axis, moved) in input.axes.iter().zip(&motion.axes) {
            let (off, excess) = errors(axis, moved);
            assert!(off <= 1e-9 && excess <= 1e-9, "{n}: off {off:e}, excess {excess:e}\n{axis:?}\n{moved:?}\n{input:?}");
            (worst_off, worst_excess) = (worst_off.max(off), worst_excess.max(excess));
            let together = input.sync == Sync::None || moved.duration == motion.duration;
            assert!(together && moved.duration >= input.minimum_duration * (1.0 - 1e-12), "{n}: durations\n{input:?}");
        }
    }
    println!("{count} problems: ends off by {worst_off:e}, limits exceeded by {worst_excess:e}");
}
