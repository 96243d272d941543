use super::super::testing::{drive, parked, query, room, shuttle};
use super::super::{Outcome, Run};
use crate::world::Mover;

const ROOM: [f64; 4] = [0.0, 0.0, 10.0, 6.0];
const BEND: [[f64; 2]; 3] = [[1.0, 1.0], [5.0, 1.0], [5.0, 4.0]];

fn guided(movers: Vec<Mover>, seed: u64) -> Run {
    let world = room(ROOM, Vec::new(), movers);
    drive("guided-dwa", &query(&world, &BEND), &BEND, seed, |_| {})
}

#[test]
fn a_free_path_is_followed_closely() {
    let run = guided(Vec::new(), 0);
    assert_eq!(run.outcome, Outcome::Arrived, "{:?}", run.events);
    println!("{} {:?} {:?}", run.time, run.tracking, run.step_seconds);
    assert!(run.tracking.path_error < 0.1 && run.tracking.tpe < 0.06, "{:?}", run.tracking);
}

#[test]
fn a_parked_mover_is_passed_without_a_new_plan() {
    let run = guided(vec![parked(0.3, [3.0, 1.0])], 0);
    println!("{} {:?} {:?} {:?}", run.time, run.min_separation, run.events, run.step_seconds);
    assert_eq!((run.outcome, run.replans), (Outcome::Arrived, 0), "{:?}", run.events);
}

#[test]
fn crossing_movers_are_let_through_in_every_phase() {
    for seed in 0..30 {
        let phase = seed as f64 * 0.7;
        let run = guided(vec![shuttle(0.3, [[3.0, 0.0], [3.0, 4.0]], 0.6, phase), shuttle(0.3, [[3.0, 2.5], [7.0, 2.5]], 0.5, 2.0 * phase)], seed);
        println!("{seed} {:?} {:.2} {:?} {:?} {} {:?}", run.outcome, run.time, run.min_separation, run.collision, run.emergency_stops, run.step_seconds);
        assert_eq!(run.outcome, Outcome::Arrived, "seed {seed} {:?}", run.events);
    }
}

#[test]
fn statistics() {
    use rand::RngExt;
    use rand_chacha::rand_core::SeedableRng;
    let smooth: Vec<[f64; 2]> = (0..=40)
        .map(|i| {
            let a = f64::from(i) / 40.0 * std::f64::consts::FRAC_PI_2;
            [3.0 + 3.0 * a.sin(), 1.0 + 3.0 * (1.0 - a.cos())]
        })
        .collect();
    let path: Vec<[f64; 2]> = std::iter::once([1.0, 1.0]).chain(smooth).chain([[6.0, 9.0]]).collect();
    let which = std::env::var("SCENE").unwrap_or_default();
    let only: Option<u64> = std::env::var("SEED").ok().and_then(|s| s.parse().ok());
    for scene in ["cross", "people", "aisle"] {
        if !which.is_empty() && which != scene {
            continue;
        }
        let (mut n, mut arrived, mut parked_hit, mut hit, mut other, mut time, mut step, mut stops) = (0, 0, vec![], vec![], vec![], 0.0, 0.0, 0);
        for seed in 0..30_u64 {
            if only.is_some_and(|s| s != seed) {
                continue;
            }
            let mut rng = rand_chacha::ChaCha8Rng::seed_from_u64(seed);
            let mut u = |a: f64, b: f64| rng.random_range(a..b);
            let (bounds, shapes) = match scene {
                "aisle" => (
                    [0.0, 0.0, 10.0, 10.0],
                    vec![crate::world::Shape::polygon(vec![[4.0, 4.5], [4.8, 4.5], [4.8, 8.0], [4.0, 8.0]]).unwrap(), crate::world::Shape::polygon(vec![[7.2, 4.5], [7.5, 4.5], [7.5, 8.0], [7.2, 8.0]]).unwrap()],
                ),
                _ => ([0.0, 0.0, 10.0, 10.0], vec![]),
            };
            let movers: Vec<Mover> = match scene {
                "cross" => (0..3)
                    .map(|i| {
                        let k = path[2 + 13 * i + 2];
                        let (a, l) = (u(0.0, 6.3), u(1.5, 3.0));
                        let d = [a.cos() * l, a.sin() * l];
                        let mut m = shuttle(u(0.25, 0.5), [[k[0] - d[0], k[1] - d[1]], [k[0] + d[0], k[1] + d[1]]], u(0.2, 0.6), u(0.0, 30.0));
                        m.appears = None;
                        m
                    })
                    .collect(),
                "people" => (0..6)
                    .map(|_| shuttle(0.3, [[u(0.0, 10.0), u(2.0, 10.0)], [u(0.0, 10.0), u(2.0, 10.0)]], u(0.4, 1.0), u(0.0, 30.0)))
                    .collect(),
                _ => vec![shuttle(0.3, [[u(5.5, 6.5), 8.5], [u(5.5, 6.5), 4.0]], u(0.4, 0.9), u(0.0, 30.0))],
            };
            if movers.iter().any(|m| { let p = m.at(0.0).0; (p[0] - 1.0).hypot(p[1] - 1.0) < 1.2 }) {
                continue;
            }
            let world = room(bounds, shapes, movers);
            let name = std::env::var("CONTROLLER").unwrap_or("guided-dwa".into());
            let mut query = query(&world, &path);
            query.clearance = 0.15;
            let run = drive(&name, &query, &path, seed, |j| j.time_limit = Some(120.0));
            n += 1;
            time += run.time;
            step += run.step_seconds.mean;
            stops += run.emergency_stops;
            match (run.outcome, &run.collision) {
                (Outcome::Arrived, _) => arrived += 1,
                (Outcome::Collision, Some(c)) if c.unavoidable => parked_hit.push(seed),
                (Outcome::Collision, _) => hit.push(seed),
                (o, _) => other.push((seed, o)),
            }
            if only.is_some() {
                for r in run.driven.iter().step_by(5) {
                    let m: Vec<String> = world.movers().iter().map(|m| { let p = m.at(r[0]).0; let d = (p[0] - r[1]).hypot(p[1] - r[2]); format!("({:.2},{:.2};{:.2})", p[0], p[1], d) }).collect();
                    println!("{:.2} x{:.2} y{:.2} yaw{:.2} v{:.2} w{:.2} {}", r[0], r[1], r[2], r[3], r[4], r[5], m.join(" "));
                }
                println!("{:?} {:?} {:?}", run.outcome, run.collision, run.events);
            }
        }
        println!("{scene}: n {n} arrived {arrived} parked-hit {parked_hit:?} hit {hit:?} other {other:?} time {:.1} step {:.2} ms stops {stops}", time / n as f64, 1e3 * step / n as f64);
    }
}
