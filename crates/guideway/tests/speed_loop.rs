//! The loop on speed: overspeed regions against sampling, and their correction by nodes.

mod ceilings;

use ceilings::{cells, dips};
use guideway::query::Limits;
use guideway::timing::{Bounds, Ceiling, Jerks, Profile, Region, correct, extremes, fastest, first_pass, overspeed, regions};
use rand::RngExt;
use rand_chacha::ChaCha8Rng;
use rand_chacha::rand_core::SeedableRng;

const NOMINAL: Limits = Limits {
    speed: 2.0,
    acceleration: 5.0,
    deceleration: 5.0,
    jerk: 10.0,
    turn_rate: Some(2.0),
    turn_acceleration: None,
    lateral_acceleration: Some(2.0),
};

fn bounds() -> Bounds {
    Bounds::from(&NOMINAL)
}

/// A ceiling of 2 m/s over 10 m with other values on some stretches (from, to, speed).
fn steps(stretches: &[(f64, f64, f64)]) -> Ceiling {
    let at = |s: f64| stretches.iter().filter(|r| s > r.0 && s < r.1).map(|r| r.2).fold(2.0, f64::min);
    Ceiling::from_cells(10.0, (0..1000).map(|i| at(0.01 * (f64::from(i) + 0.5))).collect())
}

fn first() -> Vec<(f64, Profile)> {
    vec![(0.0, first_pass(10.0, &NOMINAL).unwrap())]
}

fn near(x: f64, y: f64, tolerance: f64) {
    assert!((x - y).abs() <= tolerance, "{x} is not {y} within {tolerance}");
}

#[test]
fn the_first_pass_knows_nothing_of_the_ceiling() {
    near(first_pass(34f64.sqrt(), &NOMINAL).unwrap().duration(), 3.80990, 1e-4);
    assert!(first_pass(-1.0, &Limits { jerk: 0.0, ..NOMINAL }).is_err());
    assert_eq!(regions(&first(), &steps(&[])), Vec::new());
}

#[test]
fn one_region_is_measured_exactly() {
    let found = regions(&first(), &steps(&[(4.0, 6.0, 1.5)]));
    assert_eq!(found.len(), 1);
    let Region { from, to, worst, ratio, excess } = found[0];
    near(from, 4.0, 1e-9);
    near(to, 6.0, 1e-9);
    assert!((4.0..=6.0).contains(&worst));
    near(ratio, 2.0 / 1.5, 1e-12);
    near(excess, 2.0 * (2.0 / 1.5 - 1.0), 1e-9);
    near(overspeed(&found, 10.0), 0.2 * (2.0 / 1.5 - 1.0), 1e-10);
}

#[test]
fn regions_nearer_than_a_tenth_of_a_metre_are_one() {
    let apart = regions(&first(), &steps(&[(3.0, 4.0, 1.5), (4.11, 5.0, 1.0)]));
    assert_eq!(apart.len(), 2);
    let merged = regions(&first(), &steps(&[(3.0, 4.0, 1.5), (4.09, 5.0, 1.0)]));
    assert_eq!(merged.len(), 1);
    near(merged[0].from, 3.0, 1e-9);
    near(merged[0].to, 5.0, 1e-9);
    near(merged[0].ratio, 2.0, 1e-12);
    near(merged[0].excess, 1.0 / 3.0 + 0.91, 1e-9);
    assert_eq!(extremes(&first(), &steps(&[(3.0, 4.0, 1.5), (4.09, 5.0, 1.0)])).len(), 2);
}

#[test]
fn regions_at_the_very_ends() {
    let found = regions(&first(), &steps(&[(0.0, 1.0, 0.5), (9.0, 10.0, 0.5)]));
    assert_eq!(found.len(), 2);
    // From rest with constant jerk 0.5 m/s is reached after 0.3162 s.
    let begin = 10.0 * 0.1f64.sqrt().powi(3) / 6.0;
    near(found[0].from, begin, 1e-9);
    near(found[0].to, 1.0, 1e-9);
    near(found[1].from, 9.0, 1e-9);
    near(found[1].to, 10.0 - begin, 1e-9);
    near(found[0].excess, found[1].excess, 1e-9);
}

/// Regions by brute force: 400 000 samples of the time.
fn sampled(chain: &[(f64, Profile)], ceiling: &Ceiling) -> (f64, f64) {
    let (mut worst, mut excess) = (1.0f64, 0.0);
    for (from, profile) in chain {
        let n = 100_000;
        let dt = profile.duration() / f64::from(n);
        for k in 0..n {
            let (s, v, ..) = profile.at(dt * (f64::from(k) + 0.5));
            let ratio = v / ceiling.at(from + s);
            worst = worst.max(ratio);
            excess += (ratio - 1.0).max(0.0) * v * dt;
        }
    }
    (worst, excess)
}

#[test]
fn random_regions_agree_with_samples() {
    let mut rng = ChaCha8Rng::seed_from_u64(3);
    for _ in 0..40 {
        let length = 2.0 + 8.0 * rng.random::<f64>();
        let ceiling = cells(&dips(&mut rng, length, 2.0), length, 2.0, 500);
        let chain = vec![(0.0, first_pass(length, &NOMINAL).unwrap())];
        let found = regions(&chain, &ceiling);
        let (worst, excess) = sampled(&chain, &ceiling);
        near(found.iter().map(|r| r.ratio).fold(1.0, f64::max), worst, 1e-3);
        near(found.iter().map(|r| r.excess).sum(), excess, 1e-4);
        let tops = extremes(&chain, &ceiling);
        for region in &found {
            assert!(tops.iter().any(|(s, r)| *s == region.worst && *r == region.ratio), "{region:?} {tops:?}");
            assert!(region.from < region.to && region.from <= region.worst && region.worst <= region.to && region.ratio > 1.0);
        }
        assert!(found.windows(2).all(|w| w[1].from - w[0].to > 0.1));
    }
}

/// Continuous in position, speed and acceleration (to 1e-9), with zero acceleration at the nodes, from end to end.
fn is_continuous(chain: &[(f64, Profile)], length: f64, ends: (f64, f64)) {
    let mut state = (0.0, ends.0, 0.0);
    for (from, profile) in chain {
        near(*from, state.0, 1e-9 * length.max(1.0));
        near(profile.start().0, state.1, 1e-9);
        near(profile.start().1, state.2, 1e-8);
        let (s, v, a, _) = profile.at(f64::INFINITY);
        state = (from + s, v, a);
    }
    near(state.0, length, 1e-9 * length.max(1.0));
    near(state.1, ends.1, 1e-9);
    near(state.2, 0.0, 1e-8);
}

#[test]
fn a_ceiling_without_regions_needs_no_node() {
    let done = correct(&steps(&[]), &bounds(), (0.0, 0.0)).unwrap();
    assert_eq!((done.chain.len(), done.passes, done.before.len(), done.after.len(), done.log.len()), (1, 1, 0, 0, 0));
    assert_eq!(done.nodes, vec![(0.0, 0.0), (10.0, 0.0)]);
}

#[test]
fn a_flat_dip_is_corrected_by_a_node_at_either_end() {
    let done = correct(&steps(&[(4.0, 6.0, 1.0)]), &bounds(), (0.0, 0.0)).unwrap();
    assert_eq!((done.before.len(), done.after.len()), (1, 0));
    assert!(done.nodes.contains(&(4.0, 1.0)) && done.nodes.contains(&(6.0, 1.0)), "{:?}", done.nodes);
    is_continuous(&done.chain, 10.0, (0.0, 0.0));
    let best: f64 = fastest(&steps(&[(4.0, 6.0, 1.0)]), &bounds(), (0.0, 0.0)).unwrap().iter().map(|(_, p)| p.duration()).sum();
    // Slower, but not by much: the search dips below the ground and so brakes later.
    assert!((1.0..1.01).contains(&(done.duration() / best)), "{} {best}", done.duration());
}

#[test]
fn speeds_at_the_ends_are_kept_or_refused() {
    let ceiling = steps(&[(4.0, 6.0, 1.0)]);
    let done = correct(&ceiling, &bounds(), (1.5, 0.7)).unwrap();
    is_continuous(&done.chain, 10.0, (1.5, 0.7));
    for slow in [[(0.0, 1.0, 0.5)], [(9.0, 10.0, 0.5)], [(0.2, 1.0, 0.5)]] {
        let refused = correct(&steps(&slow), &bounds(), (1.5, 0.7));
        assert_eq!(refused.unwrap_err().name(), "Infeasible");
    }
}

#[test]
fn a_ceiling_near_zero_ends_too() {
    for low in [1e-5, 1e-3, 0.02] {
        let done = correct(&steps(&[(2.0, 2.01, low), (5.0, 5.5, low), (9.995, 10.0, low)]), &bounds(), (0.0, 0.0)).unwrap();
        assert!(done.after.is_empty());
        is_continuous(&done.chain, 10.0, (0.0, 0.0));
    }
}

/// A random problem: dips, steps or both; short ones, so that thousands are quick.
fn problem(rng: &mut ChaCha8Rng, case: usize) -> (Ceiling, Bounds, (f64, f64)) {
    let sets = [(0.5, 0.5, 2.0, 1.0), (5.0, 5.0, 10.0, 2.0), (2.0, 3.0, 10.0, 2.0), (1.0, 1.0, 1.0, 2.0)];
    let (acceleration, deceleration, j, speed) = sets[case % sets.len()];
    let length = 0.5 + 3.5 * rng.random::<f64>();
    let count = (25.0 * length) as u32 + 4;
    let smooth = cells(&dips(rng, length, speed), length, speed, count);
    let mut values = smooth.cells().to_vec();
    if case.is_multiple_of(3) {
        for _ in 0..rng.random_range(1..4) {
            let (from, wide, low) = (rng.random_range(0..values.len()), rng.random_range(1..20), speed * rng.random::<f64>().powi(2).max(1e-4));
            values.iter_mut().skip(from).take(wide).for_each(|v| *v = v.min(low));
        }
    }
    let ends = if case.is_multiple_of(5) { [values[0], values[values.len() - 1]].map(|v| 0.6 * v * rng.random::<f64>()) } else { [0.0; 2] };
    let bounds = Bounds { speed, acceleration, deceleration, jerk: Jerks::all(j) };
    (Ceiling::from_cells(length, values), bounds, (ends[0], ends[1]))
}

fn duration(chain: &[(f64, Profile)]) -> f64 {
    chain.iter().map(|(_, p)| p.duration()).sum()
}

/// Corrects and searches random problems; prints durations of the nodes over those of the search.
fn nodes_and_search(cases: usize, seed: u64) {
    let mut rng = ChaCha8Rng::seed_from_u64(seed);
    let (mut ratios, mut passes, mut refused) = (Vec::new(), 0, 0);
    for case in 0..cases {
        let (ceiling, bounds, ends) = problem(&mut rng, case);
        let (done, best) = (correct(&ceiling, &bounds, ends), fastest(&ceiling, &bounds, ends));
        let (Ok(done), Ok(best)) = (&done, &best) else {
            // Speeds at the ends may not fit; then neither finds anything, or the search does.
            assert!(ends != (0.0, 0.0) && done.is_err(), "case {case}: {:?} {:?}", done.err(), best.err());
            refused += 1;
            continue;
        };
        assert!(done.after.is_empty() && regions(&done.chain, &ceiling).is_empty() && regions(best, &ceiling).is_empty());
        for chain in [&done.chain, best] {
            is_continuous(chain, ceiling.length(), ends);
        }
        assert!(done.nodes.windows(2).all(|w| w[1].0 - w[0].0 >= 0.01 * (1.0 - 1e-6)), "{:?}", done.nodes);
        let ratio = done.duration() / duration(best);
        assert!(ratio >= 1.0, "case {case}: the search is slower than the nodes by {ratio}");
        passes = passes.max(done.passes);
        ratios.push(ratio);
    }
    ratios.sort_by(f64::total_cmp);
    let (n, mean) = (ratios.len(), ratios.iter().sum::<f64>() / ratios.len() as f64);
    println!(
        "{n} ceilings, nodes over search: mean {mean:.4}, 95 % {:.4}, most {:.4}; at most {passes} passes; {refused} refused",
        ratios[n * 95 / 100],
        ratios[n - 1]
    );
    assert!(refused * 10 < cases);
}

#[test]
fn the_search_is_never_slower_than_the_nodes() {
    nodes_and_search(2000, 4);
}

#[cfg(feature = "slow")]
#[test]
fn the_search_is_never_slower_than_the_nodes_on_many_ceilings() {
    nodes_and_search(20_000, 5);
}
