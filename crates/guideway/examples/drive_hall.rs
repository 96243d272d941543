//! Drives a hall with shelves among forklifts and people, seed after seed: arrivals, distances, and the time of a control step.
//!
//! `cargo run --release --example drive_hall [CONTROLLER] [SEEDS]`

use guideway::context::Context;
use guideway::drive::{Ask, Job, Outcome, Run, Setup, controller, execute};
use guideway::error::PlanError;
use guideway::plan::planner;
use guideway::query::{Limits, Query};
use guideway::refine::{Refiner, Smooth};
use guideway::timing::{TimingOptions, Trajectory, time};
use guideway::world::{Footprint, Loop, Mover, Shape, World};
use std::sync::Arc;

const LIMITS: Limits = Limits {
    speed: 1.5,
    acceleration: 0.8,
    deceleration: 1.0,
    jerk: 3.0,
    turn_rate: Some(1.5),
    turn_acceleration: Some(3.0),
    lateral_acceleration: Some(0.8),
};

fn shuttle(shape: Footprint, [a, b]: [[f64; 2]; 2], speed: f64, phase: f64) -> Mover {
    let length = (a[0] - b[0]).hypot(a[1] - b[1]);
    Mover { shape, track: vec![[0.0, a[0], a[1]], [length / speed, b[0], b[1]]], repeat: Loop::Shuttle, phase, appears: None }
}

/// Six rows of shelves, two forklifts across the lanes, two people along and across.
fn hall(seed: u64) -> Result<Arc<World>, PlanError> {
    let shelf = |i: u32| {
        let (x, y) = (4.0 + 5.0 * f64::from(i % 3), if i < 3 { 2.0 } else { 10.0 });
        Shape::polygon(vec![[x, y], [x + 1.2, y], [x + 1.2, y + 6.0], [x, y + 6.0]])
    };
    let shapes = (0..6).map(shelf).collect::<Result<Vec<_>, _>>()?;
    let phase = |k: f64| (seed as f64 * 1.37 * k) % 40.0;
    let movers = vec![
        shuttle(Footprint::Box([1.4, 0.9]), [[1.0, 9.0], [19.0, 9.0]], 0.7, phase(1.0)),
        shuttle(Footprint::Box([1.0, 0.8]), [[7.1, 1.0], [7.1, 17.0]], 0.5, phase(1.7)),
        shuttle(Footprint::Disc(0.3), [[12.1, 2.0], [12.1, 16.0]], 0.9, phase(2.3)),
        shuttle(Footprint::Disc(0.3), [[16.5, 4.0], [19.5, 14.0]], 0.8, phase(3.1)),
    ];
    Ok(Arc::new(World::from_shapes([0.0, 0.0, 20.0, 18.0], shapes, 0.1)?.with_movers(movers)))
}

fn motion(query: &Query, ctx: &mut Context) -> Result<Trajectory, PlanError> {
    let raw = planner("theta-star", serde_json::Value::Null)?.plan(query, ctx)?.path;
    let path = Smooth::default().refine(&raw, query, ctx)?.path;
    time(&path, &LIMITS, &TimingOptions { start_yaw: query.start_yaw, ..TimingOptions::default() }, ctx)
}

fn drive(name: &str, seed: u64) -> Result<Run, PlanError> {
    let mut query = Query::new(hall(seed)?, [1.5, 1.5], [18.5, 16.5]);
    (query.footprint, query.clearance) = (Footprint::Disc(0.35), 0.15);
    let trajectory = motion(&query, &mut Context::new(seed))?;
    let mut job = Job::new(&query, &trajectory)?;
    let again = |ask: &Ask, ctx: &mut Context| motion(&ask.query, ctx);
    job.arrival = 0.2;
    job.replanner = Some(&again);
    let setup = Setup { world: Arc::clone(&query.world), robot: job.robot.clone(), clearance: query.clearance };
    execute(&job, controller(name, serde_json::Value::Null, &setup)?.as_mut(), &mut Context::new(seed))
}

fn main() -> Result<(), PlanError> {
    let name = std::env::args().nth(1).unwrap_or_else(|| "improved-dwa".into());
    let seeds = std::env::args().nth(2).and_then(|s| s.parse().ok()).unwrap_or(30);
    let (mut arrived, mut mean, mut p99) = (0, 0.0, 0.0_f64);
    for seed in 0..seeds {
        let run = drive(&name, seed)?;
        arrived += u64::from(run.outcome == Outcome::Arrived);
        (mean, p99) = (mean + run.step_seconds.mean / seeds as f64, p99.max(run.step_seconds.p99));
        let near = run.min_separation.movers.unwrap_or(f64::INFINITY);
        let hit = run.collision.map(|c| format!("{} unavoidable {}", c.with, c.unavoidable)).unwrap_or_default();
        println!(
            "{seed:3} {:?} {:.1} s, {near:.2} m from movers, {} replans, {} emergency stops {hit}",
            run.outcome, run.time, run.replans, run.emergency_stops
        );
    }
    println!("{name}: {arrived} of {seeds} arrived; control step {:.3} ms mean, {:.3} ms worst 99th percentile", 1e3 * mean, 1e3 * p99);
    Ok(())
}
