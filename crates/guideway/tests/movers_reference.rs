//! Motions among movers against searches of another kind: speeds and times on a fine grid, and the plane in steps of a tenth of a second.

mod common_movers;

use common_movers::{KEPT, least, least_after_a_brake, limits, room, shuttle};
use guideway::context::Context;
use guideway::path::Path;
use guideway::plan::planner;
use guideway::query::Query;
use guideway::timing::movers::{Among, among};
use guideway::timing::{TimingOptions, ceiling, stop_distance};
use guideway::world::Mover;

const DT: f64 = 0.1;
const DS: f64 = 0.005;
const LEVELS: usize = 21;

/// Earliest arrival (s) at the end of a path over all profiles whose speed is a multiple of 0.1 m/s every 0.1 s and changes by at most 2 m/s2 (what a jerk of 10 m/s3
/// leaves of a change between rest and 2 m/s), by going through all of them. Places in between are not looked at.
fn exhaustive(path: &Path, movers: &[Mover], passive: bool) -> Option<f64> {
    let (limits, n) = (limits(), (path.length() / DS).round() as usize);
    let rows = ceiling(path, &limits);
    let point = |s: f64| path.planar(s.min(path.length())).point;
    let highest: Vec<f64> = (0..=n).map(|i| rows[(rows.len() * i / (n + 1)).min(rows.len() - 1)].1).collect();
    let points: Vec<[f64; 2]> = (0..=n + 600).map(|i| point(DS * i as f64)).collect();
    let gap = |i: usize, t: f64| movers.iter().map(|m| m.distance(points[i], t)).fold(f64::INFINITY, f64::min);
    let top = movers.iter().map(Mover::top_speed).fold(0.0, f64::max);
    let mut here = vec![[false; LEVELS]; n + 1];
    here[0][0] = true;
    for layer in 1..600 {
        let t = DT * f64::from(layer);
        let gaps: Vec<f64> = (0..points.len()).map(|i| if i % 4 == 0 { gap(i, t) } else { f64::INFINITY }).collect();
        let near = |i: usize| gaps[i - i % 4];
        let brakes = |i: usize, k: usize| {
            let v = 0.1 * k as f64;
            let (way, time) = (stop_distance(v, 0.1, &limits), 0.1 + 2.0 * (v / limits.jerk).sqrt());
            k == 0 || !passive || (0..=4).all(|q| near(i + (way * f64::from(q) / 4.0 / DS) as usize) - top * time * f64::from(q) / 4.0 >= KEPT)
        };
        let mut next = vec![[false; LEVELS]; n + 1];
        let reached = here.iter().enumerate().flat_map(|(i, row)| row.iter().enumerate().filter(|(_, on)| **on).map(move |(k, _)| (i, k)));
        for (i, k) in reached {
            let changes = (k.saturating_sub(2)..=(k + 2).min(LEVELS - 1)).map(|to| (i + k + to, to));
            for (j, to) in changes {
                let slow = j <= n && 0.1 * to as f64 <= highest[j];
                if slow && !next[j][to] && near(j) >= KEPT && brakes(j, to) {
                    next[j][to] = true;
                }
            }
        }
        if next[n - 4..].iter().any(|row| row[0] || row[1]) {
            return Some(t);
        }
        here = next;
    }
    None
}

#[test]
fn as_early_as_all_profiles_of_a_fine_grid() {
    let path = Path::polyline(&[[0.0, 0.0], [7.0, 0.0]]);
    let mut sums = [(0.0, 0.0); 2];
    for k in 0..6 {
        let k = f64::from(k);
        let movers = [
            shuttle([2.0, -2.0], [2.0, 2.0], 0.5, 1.3 * k),
            shuttle([4.0, -2.5], [4.0, 2.5], 0.7, 2.1 * k),
            shuttle([5.5, -3.0], [5.5, 1.5], 0.4, 3.1 * k),
        ];
        for passive in [false, true] {
            let around = Among { passive, ..Among::new(&movers, KEPT) };
            let timed = among(&path, &limits(), &TimingOptions::default(), &around, &mut Context::new(1)).unwrap();
            let duration = timed.trajectory.duration();
            match exhaustive(&path, &movers, passive) {
                Some(best) => {
                    println!("{k} passive {passive}: {duration:.2} s, grid {best:.2} s, {:?}", timed.record);
                    assert!(timed.record.passive == passive && least(&timed.trajectory, &movers) >= KEPT - 1e-9);
                    let sum = &mut sums[usize::from(passive)];
                    *sum = (sum.0 + duration, sum.1 + best);
                }
                None => assert!(!timed.record.passive, "{:?}", timed.record),
            }
        }
    }
    println!("{sums:?} s in all: ours and the grid's, without and with brakes");
    // The brakes of the grid begin without acceleration: shorter than those of a motion that speeds up, which has to keep farther away.
    assert!(sums[0].0 <= 1.05 * sums[0].1 && sums[1].0 <= 1.15 * sums[1].1, "{sums:?}");
}

/// Whether the goal can be reached at all, and when (s): steps of 0.1 s between the points of a grid of 0.1 m, at up to 2 m/s in any direction.
fn reachable(query: &Query) -> Option<f64> {
    let (nx, ny) = (101, 61);
    let at = |i: usize, j: usize| [0.1 * i as f64, 0.1 * j as f64];
    let free: Vec<bool> = (0..nx * ny).map(|c| query.world.clearance(at(c % nx, c / nx)) >= KEPT || c == 0).collect();
    let movers = query.world.movers();
    let mut here = vec![false; nx * ny];
    here[0] = true;
    for layer in 1..300 {
        let t = DT * f64::from(layer);
        let mut next = vec![false; nx * ny];
        for c in (0..nx * ny).filter(|&c| here[c]) {
            let (i, j) = (c % nx, c / nx);
            for (x, y) in (i.saturating_sub(2)..=(i + 2).min(nx - 1)).flat_map(|x| (j.saturating_sub(2)..=(j + 2).min(ny - 1)).map(move |y| (x, y))) {
                let d = y * nx + x;
                let step = (x as f64 - i as f64).hypot(y as f64 - j as f64);
                next[d] = next[d] || step <= 2.0 && free[d] && movers.iter().all(|m| m.distance(at(x, y), t) >= KEPT);
            }
        }
        if next[30 * nx + 50] {
            return Some(t);
        }
        here = next;
    }
    None
}

#[test]
fn the_room_is_solved_wherever_it_can_be() {
    let (mut solved, mut possible) = (0, 0);
    for seed in 0..10 {
        let query = room(seed);
        let best = reachable(&query);
        let solution = planner("iascv", serde_json::json!({"timing": "time-optimal"})).unwrap().plan(&query, &mut Context::new(1)).unwrap();
        let told = &solution.trace["speed"]["movers"];
        let motion = solution.trajectory.unwrap();
        println!("{seed}: grid {best:?} s, {:.2} s, {told}", motion.duration());
        if told["timed"] == true {
            assert!(least(&motion, query.world.movers()) >= KEPT - 1e-9);
            assert!(told["passive"] == false || least_after_a_brake(&motion, query.world.movers(), 0.1) >= KEPT - 0.01);
        }
        (solved, possible) = (solved + usize::from(told["timed"] == true), possible + usize::from(best.is_some()));
    }
    assert!(solved == possible, "{solved} of {possible}");
}
