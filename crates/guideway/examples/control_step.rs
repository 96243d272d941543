//! Time of one control step at 20 Hz with a lidar of 360 rays among 20 movers, tracking included, on one thread.
//!
//! `cargo run --release --package guideway --example control_step`
//!
//! Timed by the CPU clock of the thread, which a busy machine does not stretch; the few steps that plan anew are listed apart, plan and all. `checksum` is one
//! of all commands: two builds that decide alike print the same. An argument `known` or `none` asks for one of the maps.

use guideway::context::Context;
use guideway::drive::{
    Ask, CONTROLLERS, Eyes, Lidar, Observation, Outline, OwnReplanner, Pilot, Planning, Plant, Robot, Setup, Unicycle, controller, visible,
};
use guideway::error::PlanError;
use guideway::plan;
use guideway::query::{Limits, Query};
use guideway::world::{Footprint, Loop, Mover, Shape, World};
use rustix::time::{ClockId, clock_gettime};
use serde_json::Value;
use std::sync::Arc;

const DT: f64 = 0.05;
const STEPS: usize = 600;
const PILLARS: [[f64; 3]; 6] = [[3.0, 2.0, 0.3], [5.0, 5.5, 0.4], [7.0, 3.0, 0.3], [9.0, 6.0, 0.35], [10.0, 1.5, 0.3], [2.5, 6.5, 0.3]];

/// 20 discs that go to and fro at 0.2 to 0.6 m/s all over the hall.
fn movers() -> Vec<Mover> {
    (0..20)
        .map(|i| {
            let k = f64::from(i);
            let (x, y, angle) = (1.0 + (k * 2.37).rem_euclid(10.0), 1.0 + (k * 1.73).rem_euclid(6.0), k * 2.4);
            let (dx, dy) = (1.5 * f64::cos(angle), 1.5 * f64::sin(angle));
            let track = vec![[0.0, x - dx, y - dy], [3.0 / (0.2 + 0.02 * k), x + dx, y + dy]];
            Mover { shape: Footprint::Disc(0.2), track, repeat: Loop::Shuttle, phase: 0.37 * k, appears: None }
        })
        .collect()
}

/// Time that this thread has had on a CPU, s.
fn busy() -> f64 {
    let t = clock_gettime(ClockId::ThreadCPUTime);
    t.tv_sec as f64 + 1e-9 * t.tv_nsec as f64
}

fn main() -> Result<(), PlanError> {
    let pillars = PILLARS.iter().map(|[x, y, r]| Shape::disc([*x, *y], *r)).collect::<Result<_, _>>()?;
    let world = Arc::new(World::from_shapes([0.0, 0.0, 12.0, 8.0], pillars, 0.05)?.with_movers(movers()));
    let limits = Limits {
        speed: 1.0,
        acceleration: 1.0,
        deceleration: 1.0,
        jerk: 10.0,
        turn_rate: Some(2.0),
        turn_acceleration: Some(4.0),
        ..Limits::default()
    };
    println!(
        "| map | steps | median ms | 99 % ms | worst ms | with a new plan | median ms | worst ms | checksum |\n|---|---|---|---|---|---|---|---|---|"
    );
    let asked = std::env::args().nth(1);
    for known in [true, false].into_iter().filter(|known| asked.as_deref().is_none_or(|map| (map == "known") == *known)) {
        let (mut steps, mut plans) = (Vec::new(), Vec::new());
        let mut sum = 0;
        for seed in 0..5 {
            sum ^= drive(&world, (known, seed), limits, (&mut steps, &mut plans))?;
        }
        let at = |all: &mut Vec<f64>, share: f64| {
            all.sort_by(f64::total_cmp);
            all.get(((all.len().max(1) - 1) as f64 * share).round() as usize).map_or(f64::NAN, |s| 1e3 * s)
        };
        let (name, n, m) = (if known { "known" } else { "none" }, steps.len(), plans.len());
        let times = [0.5, 0.99, 1.0].map(|share| format!("{:.3}", at(&mut steps, share))).join(" | ");
        let planned = [0.5, 1.0].map(|share| format!("{:.1}", at(&mut plans, share))).join(" | ");
        println!("| {name} | {n} | {times} | {m} | {planned} | {sum:016x} |");
    }
    Ok(())
}

/// One drive through the hall; the times of its steps and of those that planned, s, and a checksum of its commands.
fn drive(world: &Arc<World>, (known, seed): (bool, u64), limits: Limits, (steps, plans): (&mut Vec<f64>, &mut Vec<f64>)) -> Result<u64, PlanError> {
    let map = if known { Arc::clone(world) } else { Arc::new(World::from_shapes(world.bounds(), Vec::new(), 0.05)?) };
    let mut query = Query::new(Arc::clone(&map), [0.6, 4.0], [11.4, 4.0]);
    (query.footprint, query.clearance) = (Footprint::Disc(0.2), 0.1);
    let planning = Arc::new(Planning::new(plan::planner("visibility", Value::Null)?, limits));
    let mut ctx = Context::new(seed);
    let motion = planning.motion(&Ask { query: query.clone(), speed: 0.0 }, &mut ctx)?;
    let robot = Robot::new(query.footprint.clone(), &limits)?;
    let setup = Setup { world: map, robot: robot.clone(), clearance: query.clearance };
    let again: Box<OwnReplanner<'static>> = Box::new(move |ask, ctx| planning.motion(ask, ctx));
    let lidar = Lidar::default();
    let chosen = controller(CONTROLLERS[0].name, Value::Null, &setup)?;
    let mut pilot = Pilot::new((&query, &motion), &robot, chosen, Some(again))?.with_eyes(Eyes::new(lidar, world, known)?);
    let mut plant = Unicycle::default().place(&robot, [0.6, 4.0, 0.0], seed);
    let mut rng = Lidar::random(seed);
    let mut sum = seed;
    for k in 0..STEPS {
        let t = DT * k as f64 + 7.0 * seed as f64;
        let there: Vec<(Outline, [f64; 2])> = visible(world.movers(), t).into_iter().map(|m| (m.outline, m.position)).collect();
        let scan = lidar.scan(world, &there, (plant.motion().pose, t), &mut rng);
        let mut seen = Observation { time: t, ..plant.observe() };
        let from = busy();
        let step = pilot.step(&mut seen, Some(scan), &mut ctx);
        if step.plan_seconds.is_empty() { &mut *steps } else { &mut *plans }.push(busy() - from);
        sum = sum.rotate_left(7) ^ step.command.v.to_bits() ^ step.command.w.to_bits().rotate_left(32);
        plant.step(step.command, DT);
    }
    Ok(sum)
}
