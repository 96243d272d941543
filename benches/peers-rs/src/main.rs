//! One-axis S-curve planning, Guideway beside `rsruckig`, the same inputs in one run: `cargo run --release -p peers-rs`.
//!
//! Every input lies in Guideway's guaranteed domain and is solved by both; each call is timed as a batch over all inputs, both take
//! turns on arrays of their own, and the table shows the median of the rounds. Inputs are built beforehand. Both validate their input in the call.

use guideway::timing::{Bounds, Jerks, Profile, SCurve};
use rand::RngExt;
use rand_chacha::ChaCha8Rng;
use rand_chacha::rand_core::SeedableRng;
use rsruckig::prelude::{InputParameter, Ruckig, ThrowErrorHandler, Trajectory, daov_stack};
use std::hint::black_box;
use std::time::Instant;

const INPUTS: usize = 10_000;
const ROUNDS: usize = 15;

/// What is drawn at the boundary.
#[derive(Clone, Copy)]
enum Ends {
    Rest,
    Speeds,
    Accelerations,
}

struct Case {
    name: &'static str,
    ends: Ends,
    asymmetric: bool,
}

/// One axis as `rsruckig` takes it.
fn peer_input(c: &SCurve) -> InputParameter<1> {
    let mut input = InputParameter::new(None);
    input.target_position = daov_stack![c.distance];
    input.current_velocity = daov_stack![c.start.0];
    input.current_acceleration = daov_stack![c.start.1];
    input.target_velocity = daov_stack![c.end.0];
    input.target_acceleration = daov_stack![c.end.1];
    input.max_velocity = daov_stack![c.bounds.speed];
    input.max_acceleration = daov_stack![c.bounds.acceleration];
    input.min_acceleration = Some(daov_stack![-c.bounds.deceleration]);
    input.max_jerk = daov_stack![c.bounds.jerk.build];
    input
}

/// A random problem: distance 0.1 to 6 m, speed 0.5 to 3 m/s, acceleration 1 to 10 m/s2, jerk 5 to 100 m/s3.
fn draw(rng: &mut ChaCha8Rng, case: &Case) -> SCurve {
    let mut between = |low: f64, high: f64| low + (high - low) * rng.random::<f64>();
    let (speed, acceleration, jerk) = (between(0.5, 3.0), between(1.0, 10.0), between(5.0, 100.0));
    let deceleration = if case.asymmetric { between(1.0, 10.0) } else { acceleration };
    let distance = between(0.1, 6.0);
    let (v0, v1) = match case.ends {
        Ends::Rest => (0.0, 0.0),
        _ => (speed * between(0.0, 1.0), speed * between(0.0, 1.0)),
    };
    let (a0, a1) = match case.ends {
        Ends::Accelerations => (acceleration * between(0.0, 1.0), -deceleration * between(0.0, 1.0)),
        _ => (0.0, 0.0),
    };
    SCurve { distance, start: (v0, a0), end: (v1, a1), bounds: Bounds { speed, acceleration, deceleration, jerk: Jerks::all(jerk) } }
}

fn nanoseconds(mut batch: impl FnMut()) -> f64 {
    let start = Instant::now();
    batch();
    start.elapsed().as_secs_f64() * 1e9 / INPUTS as f64
}

fn median(mut xs: Vec<f64>) -> f64 {
    xs.sort_by(f64::total_cmp);
    xs[xs.len() / 2]
}

fn run(case: &Case, seed: u64) {
    let mut rng = ChaCha8Rng::seed_from_u64(seed);
    let mut peer = Ruckig::<1, ThrowErrorHandler>::new(None, 0.005);
    let mut trajectory = Trajectory::new(None);
    let (mut curves, mut inputs): (Vec<SCurve>, Vec<InputParameter<1>>) = (Vec::with_capacity(INPUTS), Vec::with_capacity(INPUTS));
    let (mut apart, mut shorter, mut refused) = (0.0_f64, 0, 0);
    while inputs.len() < INPUTS {
        let curve = draw(&mut rng, case);
        let Ok(profile) = curve.plan() else { continue };
        let input = peer_input(&curve);
        if peer.calculate(&input, &mut trajectory).is_err() {
            refused += 1;
            continue;
        }
        let difference = profile.duration() - trajectory.get_duration();
        apart = apart.max(difference.abs());
        shorter += usize::from(difference > 1e-9);
        curves.push(curve);
        inputs.push(input);
    }
    let (mut own, mut other) = (Vec::new(), Vec::new());
    for _ in 0..ROUNDS {
        own.push(nanoseconds(|| {
            for curve in &curves {
                let _ = black_box::<Result<Profile, _>>(black_box(curve).plan());
            }
        }));
        other.push(nanoseconds(|| {
            for input in &inputs {
                let _ = black_box(peer.calculate(black_box(input), &mut trajectory));
                black_box(&trajectory);
            }
        }));
    }
    let (own, other) = (median(own), median(other));
    println!("| {} | {own:.0} | {other:.0} | {:.2} | {apart:.1e} | {shorter} | {refused} |", case.name, own / other);
}

fn main() {
    println!(
        "| inputs ({INPUTS}, median of {ROUNDS} rounds) | guideway ns | rsruckig 3.0.1 ns | ratio | largest difference of durations, s | rsruckig faster by > 1e-9 s | refused by rsruckig alone |"
    );
    println!("|---|---|---|---|---|---|---|");
    let cases = [
        Case { name: "rest to rest, symmetric", ends: Ends::Rest, asymmetric: false },
        Case { name: "rest to rest, asymmetric", ends: Ends::Rest, asymmetric: true },
        Case { name: "boundary speeds, symmetric", ends: Ends::Speeds, asymmetric: false },
        Case { name: "boundary speeds, asymmetric", ends: Ends::Speeds, asymmetric: true },
        Case { name: "boundary speeds and accelerations, symmetric", ends: Ends::Accelerations, asymmetric: false },
        Case { name: "boundary speeds and accelerations, asymmetric", ends: Ends::Accelerations, asymmetric: true },
    ];
    for (i, case) in cases.iter().enumerate() {
        run(case, 100 + i as u64);
    }
}
