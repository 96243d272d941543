//! The S-curve against regression values, random problems and an independent fine search.

mod common_scurve;

use common_scurve::{Problem, domain, flown, free, limits_excess};
use guideway::error::PlanError;
use guideway::timing::scurve::transition;
use guideway::timing::{Bounds, Jerks, SCurve};
use rand_chacha::ChaCha8Rng;
use rand_chacha::rand_core::SeedableRng;

fn bounds(speed: f64, acceleration: f64, deceleration: f64, jerk: f64) -> Bounds {
    Bounds { speed, acceleration, deceleration, jerk: Jerks::all(jerk) }
}

fn close(x: f64, y: f64, tolerance: f64) {
    assert!((x - y).abs() <= tolerance, "{x} is not {y} within {tolerance}");
}

#[test]
fn regression_values() {
    let nominal = bounds(2.0, 5.0, 5.0, 10.0);
    let at_rest = SCurve { distance: 34f64.sqrt(), start: (0.0, 0.0), end: (0.0, 0.0), bounds: nominal };
    let profile = at_rest.plan().unwrap();
    close(profile.duration(), 3.80990, 1e-4);
    for (phase, wanted) in profile.phases().iter().zip([0.4472, 0.0, 0.4472, 2.0210, 0.4472, 0.0, 0.4472]) {
        close(phase.duration, wanted, 1e-4);
    }
    let pushed = SCurve { start: (0.0, 0.5), ..at_rest }.plan().unwrap();
    close(pushed.duration(), 3.76389, 1e-4);
    for (phase, wanted) in pushed.phases().iter().zip([0.3986, 0.0, 0.4486, 2.0222, 0.4472, 0.0, 0.4472]) {
        close(phase.duration, wanted, 1e-4);
    }
    let asymmetric = SCurve { distance: 1.0, start: (0.0, 0.5), end: (0.0, 0.0), bounds: bounds(2.0, 5.0, 3.0, 10.0) }.plan().unwrap();
    close(asymmetric.duration(), 1.43805, 1e-4);
    close(asymmetric.top_speed(), 1.34968, 1e-4);
    let short = SCurve { distance: 0.05, ..at_rest }.plan().unwrap();
    close(short.duration(), 0.54288, 1e-4);
    close(short.top_speed(), 0.18420, 1e-4);
}

/// Checks one answer with independent code; returns whether there was a profile.
fn judge(problem: &Problem) -> bool {
    match problem.curve().plan() {
        Ok(profile) => {
            let end = flown(problem, profile.phases().iter().map(|p| (p.duration, p.jerk)));
            let scale = problem.distance.abs().max(1.0);
            assert!((end.s - problem.distance).abs() <= 1e-9 * scale, "distance {} of {problem:?}", end.s);
            assert!((end.v - problem.end.0).abs() <= 1e-9 && (end.a - problem.end.1).abs() <= 1e-9, "end {end:?} of {problem:?}");
            let excess = limits_excess(problem, profile.phases().iter().map(|p| (p.duration, p.jerk)));
            assert!(excess <= 1e-9, "limits exceeded by {excess} in {problem:?}\n{profile:?}");
            true
        }
        Err(PlanError::Infeasible { .. }) => false,
        Err(e) => panic!("{e} for {problem:?}"),
    }
}

fn random_problems(count: usize, seed: u64) -> (usize, usize) {
    let mut rng = ChaCha8Rng::seed_from_u64(seed);
    let mut solved = 0;
    for _ in 0..count {
        let problem = domain(&mut rng);
        let shortest = problem.shortest();
        let solvable = problem.distance >= shortest;
        let found = judge(&problem);
        let on_the_edge = (problem.distance - shortest).abs() <= 1e-9 * shortest.max(1.0);
        assert!(found == solvable || on_the_edge, "solvable {solvable}, found {found}: {problem:?}, shortest {shortest}");
        solved += usize::from(found);
    }
    (solved, count)
}

#[test]
fn random_problems_in_the_guaranteed_domain() {
    let (solved, count) = random_problems(100_000, 1);
    println!("{solved} of {count} problems have a profile, all are solved");
    assert!(solved > count / 2);
}

#[cfg(feature = "slow")]
#[test]
fn a_million_random_problems_in_the_guaranteed_domain() {
    let (solved, count) = random_problems(1_000_000, 2);
    println!("{solved} of {count} problems have a profile, all are solved");
    assert!(solved > count / 2);
}

#[test]
fn random_problems_outside_the_domain_never_break_a_limit() {
    let mut rng = ChaCha8Rng::seed_from_u64(3);
    let found = (0..5_000).filter(|_| judge(&free(&mut rng))).count();
    println!("{found} of 5000 have a profile");
    assert!(found > 3_000);
}

#[test]
fn speed_and_acceleration_are_continuous() {
    let mut rng = ChaCha8Rng::seed_from_u64(4);
    for _ in 0..100_000 {
        let problem = domain(&mut rng);
        let Ok(profile) = problem.curve().plan() else { continue };
        let mut t = 0.0;
        for phase in profile.phases() {
            t += phase.duration;
            let (before, after) = (profile.at(t - 1e-12), profile.at(t + 1e-12));
            assert!((before.1 - after.1).abs() <= 1e-9 && (before.2 - after.2).abs() <= 1e-9, "{problem:?} at {t}");
        }
    }
}

#[test]
fn distance_grows_with_the_top_speed() {
    let mut rng = ChaCha8Rng::seed_from_u64(5);
    for _ in 0..2_000 {
        let problem = domain(&mut rng);
        let mut last = 0.0;
        for i in 0..=50 {
            let low = problem.lowest_top();
            let w = low + (problem.bounds.speed - low) * f64::from(i) / 50.0;
            let d = problem.through(w, 1.0, 1.0, 1.0).1;
            assert!(d >= last - 1e-12, "D({w}) = {d} < {last} for {problem:?}");
            last = d;
        }
    }
}

/// No profile on a fine grid of top speeds, accelerations, decelerations and jerks is faster.
fn search(count: usize, grid: usize, seed: u64) {
    let mut rng = ChaCha8Rng::seed_from_u64(seed);
    let (mut done, mut near) = (0, 0);
    while done < count {
        let problem = domain(&mut rng);
        let Ok(profile) = problem.curve().plan() else { continue };
        done += 1;
        let best = problem.fine_search(grid);
        assert!(best >= profile.duration() - 1e-9, "a search found {best} s, the plan takes {} s: {problem:?}", profile.duration());
        near += usize::from(best < 1.02 * profile.duration());
    }
    println!("{count} problems: no faster profile found; the best of the grid is within 2 % in {near}");
    assert!(2 * near > count, "the search is too coarse to mean anything");
}

#[test]
fn no_searched_profile_is_faster() {
    search(1_000, 12, 6);
}

#[cfg(feature = "slow")]
#[test]
fn no_searched_profile_is_faster_on_ten_thousand_problems() {
    search(10_000, 14, 7);
}

#[test]
fn the_general_search_agrees_inside_the_domain() {
    let mut rng = ChaCha8Rng::seed_from_u64(8);
    let mut compared = 0;
    while compared < 500 {
        let mut problem = domain(&mut rng);
        problem.start.1 = 1e-9 * problem.bounds.acceleration;
        let Ok(inside) = problem.curve().plan() else { continue };
        problem.start.1 = -problem.start.1;
        let Ok(outside) = problem.curve().plan() else { continue };
        close(outside.duration(), inside.duration(), 1e-6 * inside.duration().max(1.0));
        compared += 1;
    }
}

#[test]
fn gap_problems_outside_the_domain_are_solved() {
    // Braking at both ends: the acceleration must not pass through zero in between.
    let b = bounds(2.0, 2.0, 2.0, 1.0);
    let (start, end) = ((1.0, -1.0), (0.4, 0.0));
    let direct = transition(start.into(), end.into(), &b).unwrap();
    let shortest = direct.at(f64::INFINITY).0;
    for k in 0..50 {
        let distance = shortest * (1.0 + 0.02 * f64::from(k));
        let profile = SCurve { distance, start, end, bounds: b }.plan().unwrap();
        close(profile.at(f64::INFINITY).0, distance, 1e-9);
        assert!(profile.duration() >= direct.duration() - 1e-12);
    }
}

#[test]
fn backward_zero_tiny_and_huge() {
    let b = bounds(2.0, 5.0, 3.0, 10.0);
    let forward = SCurve { distance: 1.0, start: (0.2, 0.5), end: (0.1, -0.2), bounds: b };
    let backward = SCurve { distance: -1.0, start: (-0.2, -0.5), end: (-0.1, 0.2), bounds: b };
    let (f, r) = (forward.plan().unwrap(), backward.plan().unwrap());
    close(f.duration(), r.duration(), 1e-15);
    for i in 0..=20 {
        let t = f.duration() * f64::from(i) / 20.0;
        close(f.at(t).0, -r.at(t).0, 1e-15);
    }
    let zero = SCurve { distance: 0.0, start: (0.0, 0.0), end: (0.0, 0.0), bounds: b }.plan().unwrap();
    close(zero.duration(), 0.0, 0.0);
    for distance in [1e-300, 1e-18, 1e-12, 1e-6, 1e6, 1e12, 1e100] {
        let profile = SCurve { distance, start: (0.0, 0.0), end: (0.0, 0.0), bounds: b }.plan().unwrap();
        close(profile.at(f64::INFINITY).0 / distance, 1.0, 1e-9);
    }
    for scale in [1e-9, 1e9] {
        let huge = bounds(2.0 * scale, 5.0 * scale, 3.0 * scale, 10.0 * scale);
        let profile = SCurve { distance: scale, start: (0.0, 0.0), end: (0.0, 0.0), bounds: huge }.plan().unwrap();
        let unit = SCurve { distance: 1.0, start: (0.0, 0.0), end: (0.0, 0.0), bounds: b }.plan().unwrap();
        close(profile.duration(), unit.duration(), 1e-12);
    }
}

#[test]
fn infeasible_problems_name_the_best_end_speed() {
    let b = bounds(2.0, 5.0, 3.0, 10.0);
    let problem = SCurve { distance: 0.1, start: (1.5, 0.0), end: (0.0, 0.0), bounds: b };
    let Err(PlanError::Infeasible { best_end_speed: Some(v), reason }) = problem.plan() else { panic!("must be infeasible") };
    assert!(v > 0.0 && v < 1.5 && reason.contains("shortest possible distance"), "{v}: {reason}");
    let there = SCurve { end: (v, 0.0), ..problem }.plan().unwrap();
    close(there.at(f64::INFINITY).0, 0.1, 1e-9);
    assert!(SCurve { end: (v - 1e-3, 0.0), ..problem }.plan().is_err());
    let mirrored = SCurve { distance: -0.1, start: (-1.5, 0.0), ..problem }.plan();
    assert!(matches!(mirrored, Err(PlanError::Infeasible { best_end_speed: Some(w), .. }) if (w + v).abs() < 1e-12));
}

#[test]
fn bad_input_is_refused() {
    let good = SCurve { distance: 1.0, start: (0.0, 0.0), end: (0.0, 0.0), bounds: bounds(1.0, 1.0, 1.0, 1.0) };
    for bad in [0.0, -1.0, f64::NAN, f64::INFINITY] {
        let mut cases = [good; 5];
        cases[0].bounds.speed = bad;
        cases[1].bounds.acceleration = bad;
        cases[2].bounds.deceleration = bad;
        cases[3].bounds.jerk.brake = bad;
        cases[4].distance = if bad.is_finite() { f64::NAN } else { bad };
        assert!(cases.iter().all(|c| matches!(c.plan(), Err(PlanError::BadParameter { .. }))), "{bad}");
    }
    let infeasible = [
        SCurve { start: (-0.1, 0.0), ..good },
        SCurve { start: (1.1, 0.0), ..good },
        SCurve { start: (0.9, 0.9), ..good },
        SCurve { end: (0.9, -0.9), ..good },
        SCurve { end: (0.5, -1.1), ..good },
    ];
    assert!(infeasible.iter().all(|c| matches!(c.plan(), Err(PlanError::Infeasible { .. }))));
}

#[test]
fn transitions_reach_their_end() {
    let mut rng = ChaCha8Rng::seed_from_u64(9);
    for _ in 0..50_000 {
        let problem = free(&mut rng);
        let profile = transition(problem.start.into(), problem.end.into(), &problem.bounds).unwrap();
        let end = flown(&problem, profile.phases().iter().map(|p| (p.duration, p.jerk)));
        close(end.v, problem.end.0, 1e-9);
        close(end.a, problem.end.1, 1e-9);
        assert!(profile.phases().iter().all(|p| p.duration >= 0.0));
    }
}
