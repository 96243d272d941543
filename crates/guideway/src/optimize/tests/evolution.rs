//! Differential evolution and covariance matrix adaptation: their parts, and targets in stated evaluations.

use super::super::breed::opposite;
use super::super::distribution::{Distribution, Rates};
use super::super::eigen::{dot, eigen};
use super::super::schedule::Schedule;
use super::super::*;
use super::budget;
use crate::context::{Budget, Context};
use functions::{Function, Shifted};
use proptest::prelude::*;
use rand::RngExt;
use serde_json::{Value, json};

#[test]
fn lambda_goes_from_one_to_nearly_nothing() {
    for last in [20, 500, 4000] {
        assert_eq!(decay(1, last), 1.0);
        assert!(decay(last, last) < 1e-6, "{last}");
        assert!((1..last).all(|g| decay(g + 1, last) <= decay(g, last)), "{last}");
    }
    assert!(decay(2000, 4000) > 0.36 && decay(3900, 4000) < 1e-12);
    assert!((decay(2, 2) - (-1f64).exp()).abs() < 1e-15 && decay(1, 1) == 1.0 && decay(9, 1) == 1.0);
}

#[test]
fn scale_and_crossover_run_between_their_stated_ends() {
    let ours = ImprovedDe::default();
    let literal = ImprovedDe { form: Form::Literal, ..ours };
    let doubled = ImprovedDe { scale_range: [0.6, 0.3], ..ours };
    assert!((ours.scale(1, 4000) - 0.5).abs() < 1e-12);
    assert!((ours.scale(4000, 4000) - 0.3).abs() < 1e-12);
    assert!((ours.crossover(4000, 4000) - 0.9).abs() < 1e-12);
    assert!((ours.crossover(1, 4000) - 0.3).abs() < 1e-3);
    for g in [1, 1000, 3000, 3990, 4000] {
        assert!((literal.scale(g, 4000) - doubled.scale(g, 4000)).abs() < 1e-15);
    }
}

#[test]
fn schedules_end_with_the_budget() {
    let of = |iterations, evaluations| Context::new(1).with_budget(Budget { iterations, evaluations, seconds: None }).unwrap();
    let last = |ctx: &Context| Schedule::new(4000, ctx).generations(80, 40);
    assert_eq!(last(&of(None, None)), 4000);
    assert_eq!(last(&of(Some(7000), None)), 7000);
    assert_eq!(last(&of(None, Some(400_000))), 9998);
    assert_eq!(last(&of(Some(10), Some(400_000))), 10);
    assert_eq!(last(&of(None, Some(3))), 1);
    let mut spent = of(None, Some(1000));
    spent.count_evaluations(500);
    let schedule = Schedule::new(4000, &spent);
    assert_eq!(schedule.generations(100, 100), 4);
    spent.count_evaluations(125);
    assert_eq!(schedule.share(1, &spent), 0.25);
}

#[test]
fn the_population_shrinks_to_its_least_with_the_budget() {
    let f = Shifted::aside(Function::Rosenbrock, 10, 0.3);
    for evaluations in [3000, 12_000] {
        let found = LShade { tolerance: 0.0, ..LShade::default() }.minimize(&f, &mut budget(evaluations)).unwrap();
        assert!(found.population.len() <= 13, "{}", found.population.len());
        assert_eq!((found.evaluations, found.stop), (evaluations, Stop::Budget));
    }
}

#[test]
fn restarts_go_on_where_one_run_has_ended() {
    let f = Shifted::aside(Function::Rastrigin, 5, 0.3);
    let found = |restarts| CmaEs { restarts, ..CmaEs::default() }.minimize(&f, &mut budget(40_000)).unwrap();
    let [one, ipop, bipop] = [Restarts::Off, Restarts::Ipop, Restarts::Bipop].map(found);
    assert_eq!((one.stop, ipop.stop, bipop.stop), (Stop::Converged, Stop::Budget, Stop::Budget));
    assert!(one.cost.value > 0.5 && ipop.cost.value < 1e-9 && bipop.cost.value < 1e-9, "{one:?}");
    assert!(ipop.population.len() > 2 * one.population.len());
}

#[test]
fn spread_and_patience_end_a_run() {
    let f = Shifted::plain(Function::Sphere, 3);
    let close = ImprovedDe { stagnation: 0, ..ImprovedDe::default() }.minimize(&f, &mut Context::new(1)).unwrap();
    let spread = |x: &Vec<f64>| x.iter().zip(&close.population[0]).all(|(a, b)| (a - b).abs() <= 200.0 * 1e-9);
    assert!(close.stop == Stop::Converged && close.iterations < 3999 && close.population.iter().all(spread));
    let still = De { patience: 5, tolerance: 0.0, ..De::default() }.minimize(&f, &mut Context::new(1)).unwrap();
    assert_eq!((still.stop, still.iterations - still.history.last().unwrap().0), (Stop::Converged, 5));
}

#[test]
fn every_switch_of_the_improved_method_matters() {
    let f = Shifted::aside(Function::Rastrigin, 10, 0.3);
    let base = ImprovedDe { stagnation: 5, ..ImprovedDe::default() };
    let found = |o: ImprovedDe| o.minimize(&f, &mut budget(20_000)).unwrap().history;
    let whole = found(base);
    let switches = [
        ImprovedDe { opposition: Opposition::Off, ..base },
        ImprovedDe { opposition: Opposition::Quartiles, ..base },
        ImprovedDe { form: Form::Literal, ..base },
        ImprovedDe { scale_range: [0.5, 0.5], ..base },
        ImprovedDe { crossover_range: [0.9, 0.9], ..base },
        ImprovedDe { stagnation: 0, ..base },
        ImprovedDe { renewed: 0.1, ..base },
        ImprovedDe { renewal: Renewal::Opposite, ..base },
        ImprovedDe { renewal: Renewal::Random, ..base },
    ];
    for (k, other) in switches.into_iter().map(found).enumerate() {
        assert_ne!(other, whole, "{k}");
    }
}

#[test]
fn targets_are_reached_in_stated_evaluations() {
    // Method, function, numbers, value, evaluations: by every one of eight seeds, on the function moved by 0.3 of half its box.
    let targets = [
        ("l-shade", Function::Sphere, 10, 1e-6, 6000),
        ("l-shade", Function::Rastrigin, 10, 0.1, 20_000),
        ("l-shade", Function::Ackley, 20, 1e-4, 20_000),
        ("l-shade", Function::Griewank, 20, 0.02, 20_000),
        ("cma-es", Function::Sphere, 20, 1e-10, 6000),
        ("cma-es", Function::Rosenbrock, 10, 1e-9, 20_000),
        ("cma-es", Function::Griewank, 20, 1e-9, 20_000),
        ("improved-de", Function::Sphere, 10, 1e-6, 12_000),
        ("improved-de", Function::Ackley, 10, 1e-4, 12_000),
        ("de", Function::Sphere, 10, 1e-6, 20_000),
        ("firefly", Function::Sphere, 10, 1e-6, 20_000),
    ];
    for (name, function, dimension, value, evaluations) in targets {
        let f = Shifted::aside(function, dimension, 0.3);
        let best = |seed| {
            let mut ctx = Context::new(seed).with_budget(Budget { evaluations: Some(evaluations), ..Budget::default() }).unwrap();
            optimizer(name, Value::Null).unwrap().minimize(&f, &mut ctx).unwrap().cost.value
        };
        let worst = (0..8).map(best).fold(0.0, f64::max);
        assert!(worst <= value, "{name}, {function:?}: {worst}");
    }
}

#[test]
fn a_narrow_turned_ellipsoid_is_learnt() {
    // Axes of a million to one along the diagonal: hopeless without the covariance.
    struct Turned(Vec<(f64, f64)>);
    impl Objective for Turned {
        fn bounds(&self) -> &[(f64, f64)] {
            &self.0
        }
        fn costs(&self, xs: &[Vec<f64>]) -> Result<Vec<Cost>, PlanError> {
            let value = |x: &Vec<f64>| {
                let along = x.iter().sum::<f64>() - 3.0;
                1e6 * along * along + x.iter().enumerate().map(|(k, v)| (v - 0.1 * k as f64).powi(2)).sum::<f64>()
            };
            Ok(xs.iter().map(|x| Cost::of(value(x))).collect())
        }
    }
    let f = Turned(vec![(-2.0, 7.0); 6]);
    let on = CmaEs::default().minimize(&f, &mut budget(6000)).unwrap();
    // The best point of the plane: the centres (0 to 0.5) each moved by (3 - 1.5) / 6.
    assert!((on.cost.value - 6.0 * 0.25f64.powi(2)).abs() < 1e-5, "{}", on.cost.value);
}

#[test]
fn the_edge_of_the_box_is_found() {
    struct Edge(Vec<(f64, f64)>);
    impl Objective for Edge {
        fn bounds(&self) -> &[(f64, f64)] {
            &self.0
        }
        fn costs(&self, xs: &[Vec<f64>]) -> Result<Vec<Cost>, PlanError> {
            Ok(xs.iter().map(|x| Cost::of(x[0] - x[1] + (x[2] - 0.5).powi(2))).collect())
        }
    }
    let f = Edge(vec![(-1.0, 3.0), (0.0, 8.0), (0.0, 1.0)]);
    for name in ["de", "improved-de", "l-shade", "cma-es"] {
        let found = optimizer(name, Value::Null).unwrap().minimize(&f, &mut budget(6000)).unwrap();
        assert!((found.cost.value + 9.0).abs() < 1e-4, "{name}: {found:?}");
    }
}

#[test]
fn the_registry_lists_builds_and_refuses() {
    for entry in REGISTRY {
        let defaults = (entry.defaults)();
        let names: Vec<&String> = defaults.as_object().unwrap().keys().collect();
        let listed: Vec<&str> = entry.parameters.iter().map(|p| p.name).collect();
        assert_eq!(names, listed, "{}", entry.name);
        assert!(optimizer(entry.name, defaults).is_ok() && optimizer(entry.name, Value::Null).is_ok());
    }
    let error = |name: &str, value: Value| optimizer(name, value).err().unwrap().to_string();
    assert!(error("simplex", Value::Null).contains("one of l-shade, cma-es"));
    assert!(error("de", json!({"size": 3})).contains("de.size"));
    assert!(error("de", json!({"scale": "big"})).contains("de.scale"));
    assert!(error("de", json!(3)).contains("a table of parameters"));
}

#[test]
fn parameters_that_cannot_be_are_named() {
    let f = Shifted::plain(Function::Sphere, 3);
    let bad = [
        ("de", json!({"population": 3}), "population"),
        ("de", json!({"scale": -0.1}), "scale"),
        ("de", json!({"crossover": 1.5}), "crossover"),
        ("improved-de", json!({"scale_range": [0.5, 0.0]}), "scale_range"),
        ("improved-de", json!({"crossover_range": [2.0, 0.0]}), "crossover_range"),
        ("improved-de", json!({"renewed": 2.0}), "renewed"),
        ("improved-de", json!({"tolerance": -1.0}), "tolerance"),
        ("improved-de", json!({"iterations": 0}), "iterations"),
        ("firefly", json!({"step": 2.0}), "step"),
        ("firefly", json!({"fading": 2.0}), "fading"),
        ("l-shade", json!({"least": 3}), "least"),
        ("l-shade", json!({"population": 8}), "least"),
        ("l-shade", json!({"memory": 0}), "memory"),
        ("l-shade", json!({"elite": 0.0}), "elite"),
        ("l-shade", json!({"archive": 11.0}), "archive"),
        ("cma-es", json!({"population": 3}), "population"),
        ("cma-es", json!({"step": 0.0}), "step"),
        ("cma-es", json!({"growth": 0.5}), "growth"),
    ];
    for (name, set, word) in bad {
        let error = optimizer(name, set).unwrap().minimize(&f, &mut budget(100)).unwrap_err();
        assert!(error.name() == "BadParameter" && error.to_string().contains(word), "{name}: {error}");
    }
}

#[test]
fn an_objective_that_cancels_leaves_the_best_so_far() {
    struct Tired(std::sync::atomic::AtomicUsize);
    impl Objective for Tired {
        fn bounds(&self) -> &[(f64, f64)] {
            &[(0.0, 1.0)]
        }
        fn costs(&self, xs: &[Vec<f64>]) -> Result<Vec<Cost>, PlanError> {
            let calls = self.0.fetch_add(1, std::sync::atomic::Ordering::Relaxed);
            if calls < 5 { Ok(xs.iter().map(|x| Cost::of(x[0])).collect()) } else { Err(PlanError::Cancelled) }
        }
        fn effort(&self) -> f64 {
            0.0
        }
    }
    for entry in REGISTRY {
        let found = optimizer(entry.name, Value::Null).unwrap().minimize(&Tired(0.into()), &mut budget(100_000)).unwrap();
        assert_eq!(found.stop, Stop::Cancelled, "{}", entry.name);
        assert!(found.cost.value < 1.0 && found.best[0] == found.cost.value, "{}", entry.name);
    }
}

/// A symmetric matrix with positive eigenvalues over many powers of ten.
fn symmetric(n: usize, seed: u64) -> Vec<f64> {
    let mut ctx = Context::new(seed);
    let mut matrix = vec![0.0; n * n];
    for power in 0..n {
        let v: Vec<f64> = (0..n).map(|_| ctx.rng.random::<f64>() - 0.5).collect();
        let weight = 10f64.powi(-(power as i32));
        for (k, m) in matrix.iter_mut().enumerate() {
            *m += weight * v[k / n] * v[k % n];
        }
    }
    matrix
}

proptest! {
    #[test]
    fn eigenvectors_put_the_matrix_together_again(n in 1usize..9, seed: u64) {
        let matrix = symmetric(n, seed);
        let mut basis: Vec<f64> = (0..n * n).map(|k| if k % (n + 1) == 0 { 1.0 } else { 0.0 }).collect();
        for _ in 0..2 {
            let values = eigen(&matrix, &mut basis, n);
            for i in 0..n {
                for j in 0..n {
                    let again: f64 = (0..n).map(|k| values[k] * basis[k * n + i] * basis[k * n + j]).sum();
                    prop_assert!((again - matrix[i * n + j]).abs() < 1e-12, "{again} {}", matrix[i * n + j]);
                    let unit = f64::from(u8::from(i == j));
                    prop_assert!((dot(&basis[i * n..][..n], &basis[j * n..][..n]) - unit).abs() < 1e-12);
                }
            }
        }
    }

    #[test]
    fn opposition_keeps_bounds_and_undoes_itself(sides in prop::collection::vec((-1e6f64..1e6, 1e-6f64..1e6, 0.0f64..=1.0), 1..9)) {
        let bounds: Vec<(f64, f64)> = sides.iter().map(|(low, side, _)| (*low, low + side)).collect();
        let x: Vec<f64> = sides.iter().zip(&bounds).map(|(s, b)| (s.0 + s.2 * s.1).clamp(b.0, b.1)).collect();
        let seen = opposite(&x, &bounds);
        prop_assert!(seen.iter().zip(&bounds).all(|(v, b)| (b.0..=b.1).contains(v)));
        prop_assert!(opposite(&seen, &bounds).iter().zip(&x).all(|(a, b)| (a - b).abs() <= 1e-9 * b.abs().max(1.0)));
    }

    #[test]
    fn learning_keeps_a_distribution_sound(n in 1usize..8, population in 4usize..30, active: bool, seed: u64) {
        let mut ctx = Context::new(seed);
        let mut distribution = Distribution::new(vec![0.5; n], 0.3, Rates::new(n, population, active));
        for _ in 0..40 {
            let mut places = vec![vec![0.0; n]; population];
            for place in &mut places {
                distribution.draw(place, &mut ctx.rng);
            }
            distribution.learn(&places.iter().map(Vec::as_slice).collect::<Vec<_>>());
        }
        prop_assert!(!distribution.degenerate() && distribution.reach() > 0.0);
    }

    #[test]
    fn any_box_any_method_any_size(which in 0..REGISTRY.len(), sides in prop::collection::vec((-1e3f64..1e3, 1e-3f64..1e3), 1..6), evaluations in 1u64..400, seed: u64) {
        struct Lows(Vec<(f64, f64)>);
        impl Objective for Lows {
            fn bounds(&self) -> &[(f64, f64)] {
                &self.0
            }
            fn costs(&self, xs: &[Vec<f64>]) -> Result<Vec<Cost>, PlanError> {
                let cost = |x: &Vec<f64>| Cost { violation: (self.0[0].0 + 0.1 - x[0]).max(0.0), value: x.iter().sum(), tie: 0.0 };
                assert!(xs.iter().flat_map(|x| x.iter().zip(&self.0)).all(|(v, b)| (b.0..=b.1).contains(v)));
                Ok(xs.iter().map(cost).collect())
            }
        }
        let f = Lows(sides.iter().map(|(low, side)| (*low, low + side)).collect());
        let run = |threads| {
            let budget = Budget { evaluations: Some(evaluations), ..Budget::default() };
            let mut ctx = Context::new(seed).with_budget(budget).unwrap().with_threads(threads);
            optimizer(REGISTRY[which].name, Value::Null).unwrap().minimize(&f, &mut ctx).unwrap()
        };
        let found = run(1);
        prop_assert!(found.evaluations <= evaluations && found.population.len() == found.costs.len());
        prop_assert_eq!(f.costs(std::slice::from_ref(&found.best)).unwrap()[0], found.cost);
        prop_assert!(found.costs.iter().all(|c| !c.beats(found.cost)));
        prop_assert_eq!(run(3), found);
    }
}
