use super::functions::{Function, Shifted};
use super::*;
use crate::context::Budget;

mod evolution;

const DIMENSION: usize = 10;

fn optimizers() -> Vec<(&'static str, Box<dyn Optimizer>)> {
    vec![
        ("pso", Box::new(Pso { iterations: 400, ..Pso::default() })),
        ("grouped-pso", Box::new(GroupedPso { iterations: 400, patience: 0, ..GroupedPso::default() })),
        ("sparrow", Box::new(Sparrow { iterations: 400, ..Sparrow::default() })),
        ("de", Box::new(De::default())),
        ("improved-de", Box::new(ImprovedDe::default())),
        ("firefly", Box::new(Firefly::default())),
        ("l-shade", Box::new(LShade::default())),
        ("cma-es", Box::new(CmaEs::default())),
    ]
}

/// Values found on all functions, plain or shifted by that share of the half side, the worst of three seeds.
fn worst(optimizer: &dyn Optimizer, share: f64) -> Vec<f64> {
    let run = |f: Function, seed: u64| {
        let objective = Shifted::aside(f, DIMENSION, share);
        let mut ctx = Context::new(seed).with_budget(Budget { evaluations: Some(20_000), ..Budget::default() }).unwrap();
        optimizer.minimize(&objective, &mut ctx).unwrap().cost.value
    };
    Function::ALL[..4].iter().map(|&f| (0..3).map(|seed| run(f, seed)).fold(0.0, f64::max)).collect()
}

#[test]
fn every_optimizer_finds_the_minima_of_plain_and_shifted_functions() {
    // Bounds on Sphere, Rosenbrock, Rastrigin and Ackley, about twice what was measured. Plain swarms run into a side of the box (see below).
    let bounds: [(&str, f64, [f64; 4]); 20] = [
        ("pso", 0.0, [1e-40, 20.0, 50.0, 4.0]),
        ("pso", 0.3, [1e-40, 400.0, 30.0, 1e-12]),
        ("grouped-pso", 0.0, [1e-20, 12.0, 30.0, 1e-10]),
        ("grouped-pso", 0.3, [1e-20, 20.0, 30.0, 1e-10]),
        ("grouped-pso", 0.7, [1e-20, 20.0, 60.0, 1e-10]),
        ("de", 0.0, [1e-12, 8.0, 60.0, 2e-6]),
        ("de", 0.3, [1e-12, 8.0, 60.0, 2e-6]),
        ("de", 0.7, [1e-12, 8.0, 60.0, 2e-6]),
        ("improved-de", 0.0, [1e-13, 15.0, 35.0, 1e-7]),
        ("improved-de", 0.3, [1e-13, 15.0, 35.0, 1e-7]),
        ("improved-de", 0.7, [1e-13, 15.0, 35.0, 1e-7]),
        ("firefly", 0.0, [1e-9, 6000.0, 60.0, 1e-5]),
        ("firefly", 0.3, [1e-9, 6000.0, 60.0, 1e-5]),
        ("firefly", 0.7, [1e-9, 6000.0, 60.0, 1e-5]),
        ("l-shade", 0.0, [1e-16, 0.05, 2e-3, 1e-8]),
        ("l-shade", 0.3, [1e-16, 0.05, 2e-3, 1e-8]),
        ("l-shade", 0.7, [1e-16, 0.05, 2e-3, 1e-8]),
        ("cma-es", 0.0, [1e-18, 1e-15, 30.0, 1e-9]),
        ("cma-es", 0.3, [1e-18, 1e-15, 30.0, 1e-9]),
        ("cma-es", 0.7, [1e-18, 1e-15, 30.0, 1e-9]),
    ];
    let optimizers = optimizers();
    for (name, share, most) in bounds {
        let optimizer = &optimizers.iter().find(|o| o.0 == name).unwrap().1;
        let found = worst(optimizer.as_ref(), share);
        assert!(found.iter().zip(most).all(|(f, m)| *f <= m), "{name} shifted by {share}: {found:?}");
    }
}

#[test]
fn groups_with_an_elite_get_out_where_the_plain_swarm_is_caught() {
    let optimizers = optimizers();
    let [plain, grouped] = [0, 1].map(|k| worst(optimizers[k].1.as_ref(), 0.7));
    assert!(plain[0] > 1.0 && plain[3] > 1.0, "{plain:?}");
    assert!(grouped[0] < 1e-20 && grouped[3] < 1e-10, "{grouped:?}");
}

#[test]
fn sparrows_are_drawn_to_zero() {
    let sparrow = &optimizers()[2].1;
    let (plain, shifted) = (worst(sparrow.as_ref(), 0.0), worst(sparrow.as_ref(), 0.3));
    assert!(plain.iter().all(|v| *v < 1e-9), "{plain:?}");
    assert!(shifted.iter().all(|v| *v > 1.0), "{shifted:?}");
}

/// Notes how far outside the box candidates lie and how many there are; slow enough to be worth two threads.
struct Noted {
    inner: Shifted,
    hints: Vec<Vec<f64>>,
    outside: std::sync::atomic::AtomicBool,
}

impl Objective for Noted {
    fn bounds(&self) -> &[(f64, f64)] {
        self.inner.bounds()
    }
    fn costs(&self, xs: &[Vec<f64>]) -> Result<Vec<Cost>, PlanError> {
        let inside = |x: &Vec<f64>| x.iter().zip(self.bounds()).all(|(v, b)| (b.0..=b.1).contains(v));
        self.outside.fetch_or(!xs.iter().all(inside), std::sync::atomic::Ordering::Relaxed);
        self.inner.costs(xs)
    }
    fn hints(&self) -> &[Vec<f64>] {
        &self.hints
    }
    fn effort(&self) -> f64 {
        100.0
    }
}

fn noted(hints: Vec<Vec<f64>>) -> Noted {
    Noted { inner: Shifted::aside(Function::Rastrigin, DIMENSION, 0.9), hints, outside: false.into() }
}

fn budget(evaluations: u64) -> Context<'static> {
    Context::new(5).with_budget(Budget { evaluations: Some(evaluations), ..Budget::default() }).unwrap()
}

#[test]
fn the_result_depends_on_the_seed_alone_and_stays_in_the_box() {
    for (name, optimizer) in optimizers() {
        let run = |threads, seed| {
            let f = noted(Vec::new());
            let mut ctx = Context::new(seed).with_budget(Budget { evaluations: Some(2000), ..Budget::default() }).unwrap().with_threads(threads);
            let found = optimizer.minimize(&f, &mut ctx).unwrap();
            assert!(!f.outside.into_inner(), "{name}");
            found
        };
        assert_eq!(run(1, 3), run(2, 3), "{name}");
        assert_ne!(run(1, 3).best, run(1, 4).best, "{name}");
    }
}

#[test]
fn budgets_are_kept_and_hints_are_used() {
    for (name, optimizer) in optimizers() {
        let mut ctx = budget(333);
        let found = optimizer.minimize(&noted(Vec::new()), &mut ctx).unwrap();
        assert_eq!((found.stop, found.evaluations, ctx.evaluations()), (Stop::Budget, 333, 333), "{name}");
        assert!(found.history.windows(2).all(|w| w[0].0 < w[1].0 && w[1].1.beats(w[0].1)), "{name}");
        assert_eq!(found.history.last().unwrap().1, found.cost, "{name}");
        let minimum: Vec<f64> = (0..DIMENSION).map(|k| if k % 2 == 0 { 0.9 * 5.12 } else { -0.9 * 5.12 }).collect();
        let found = optimizer.minimize(&noted(vec![minimum.clone()]), &mut budget(60)).unwrap();
        assert_eq!((found.cost.value, &found.best), (0.0, &minimum), "{name}");
        let error = optimizer.minimize(&noted(vec![vec![0.0]]), &mut budget(60)).unwrap_err();
        assert_eq!(error.name(), "BadParameter", "{name}");
    }
}

#[test]
fn cancel_and_no_time_stop_before_anything_is_costed() {
    for (name, optimizer) in optimizers() {
        let mut observer = |_: &crate::context::Progress| true;
        let found = optimizer.minimize(&noted(Vec::new()), &mut Context::new(1).with_observer(&mut observer)).unwrap();
        assert_eq!((found.stop, found.evaluations, found.best.len(), found.cost), (Stop::Cancelled, 0, 0, Cost::WORST), "{name}");
        let mut ctx = Context::new(1).with_budget(Budget { seconds: Some(0.0), ..Budget::default() }).unwrap();
        assert_eq!(optimizer.minimize(&noted(Vec::new()), &mut ctx).unwrap().stop, Stop::Budget, "{name}");
    }
}

#[test]
fn patience_ends_a_run_that_stands_still() {
    let f = Shifted::plain(Function::Sphere, 2);
    let optimizer = Pso { iterations: 100_000, patience: 30, ..Pso::default() };
    let found = optimizer.minimize(&f, &mut Context::new(1)).unwrap();
    assert_eq!((found.stop, found.cost.value), (Stop::Converged, 0.0));
    assert_eq!(found.iterations - found.history.last().unwrap().0, 30);
}

/// A function given by a closure of one number.
struct Toy<F>(F, [(f64, f64); 1]);

impl<F: Fn(f64) -> Cost + Sync> Objective for Toy<F> {
    fn bounds(&self) -> &[(f64, f64)] {
        &self.1
    }
    fn costs(&self, xs: &[Vec<f64>]) -> Result<Vec<Cost>, PlanError> {
        Ok(xs.iter().take(40).map(|x| (self.0)(x[0])).collect())
    }
}

#[test]
fn feasible_comes_first_then_value_then_tie() {
    // The least value lies where the constraint x >= 1 is broken; of the equal values above, the tie picks the largest x.
    let f = Toy(|x: f64| Cost { violation: (1.0 - x).max(0.0), value: x.min(2.0), tie: if x > 2.0 { -x } else { 0.0 } }, [(-10.0, 10.0)]);
    let small = |o: &dyn Optimizer| o.minimize(&f, &mut budget(4000)).unwrap();
    for found in
        [small(&Pso { particles: 40, iterations: 90, ..Pso::default() }), small(&Sparrow { sparrows: 40, iterations: 90, ..Sparrow::default() })]
    {
        assert!(found.cost.feasible() && (found.best[0] - 1.0).abs() < 1e-3, "{found:?}");
    }
    let g = Toy(|x: f64| Cost { violation: 0.0, value: 2.0, tie: -x }, [(-10.0, 10.0)]);
    assert!(Pso { particles: 40, ..Pso::default() }.minimize(&g, &mut budget(2000)).unwrap().best[0] > 9.9);
    let order = [Cost::of(1.0), Cost { tie: 1.0, ..Cost::of(1.0) }, Cost::of(2.0), Cost { violation: 0.5, ..Cost::of(0.0) }, Cost::WORST];
    assert!(order.windows(2).all(|w| w[0].beats(w[1]) && !w[1].beats(w[0])));
}

#[test]
fn bad_objectives_boxes_and_parameters_are_named() {
    let least = |f: &dyn Objective, o: &dyn Optimizer| o.minimize(f, &mut Context::new(1)).unwrap_err().to_string();
    let pso = Pso { particles: 40, ..Pso::default() };
    let sphere = Shifted::plain(Function::Sphere, 3);
    for bad in [Cost::of(f64::NAN), Cost::of(f64::INFINITY), Cost { violation: -1.0, ..Cost::of(0.0) }] {
        assert!(least(&Toy(move |_| bad, [(0.0, 1.0)]), &pso).contains("cost of the objective"));
    }
    assert!(least(&Toy(Cost::of, [(0.0, 1.0)]), &Pso::default()).contains("costs of the objective = 40"));
    for bounds in [(1.0, 1.0), (2.0, 1.0), (f64::NAN, 1.0), (0.0, f64::INFINITY)] {
        assert!(least(&Toy(Cost::of, [bounds]), &pso).contains("bounds"), "{bounds:?}");
    }
    assert!(least(&sphere, &Pso { particles: 1, ..Pso::default() }).contains("particles"));
    assert!(least(&sphere, &Pso { particles: usize::MAX, ..Pso::default() }).contains("particles"));
    assert!(least(&sphere, &Pso { speed: f64::NAN, ..Pso::default() }).contains("speed"));
    assert!(least(&sphere, &Pso { iterations: 0, ..Pso::default() }).contains("iterations"));
    assert!(least(&sphere, &GroupedPso { groups: 0, ..GroupedPso::default() }).contains("groups"));
    assert!(least(&sphere, &GroupedPso { social_range: [0.0, f64::NAN], ..GroupedPso::default() }).contains("social_range"));
    assert!(least(&sphere, &Sparrow { scouts: 1.1, ..Sparrow::default() }).contains("scouts"));
}

#[test]
fn every_switch_of_the_grouped_swarm_matters() {
    let f = Shifted::aside(Function::Rastrigin, DIMENSION, 0.3);
    let base = GroupedPso { iterations: 30, ..GroupedPso::default() };
    let found = |o: GroupedPso| o.minimize(&f, &mut Context::new(2)).unwrap();
    let whole = found(base);
    assert!(whole.evaluations > 50 + 30 * 55, "{}", whole.evaluations);
    let switches = [
        GroupedPso { elite: false, ..base },
        GroupedPso { second_stage: false, ..base },
        GroupedPso { regroup: 0, ..base },
        GroupedPso { groups: 1, ..base },
    ];
    for (k, other) in switches.into_iter().map(found).enumerate() {
        assert_ne!(other.best, whole.best, "{k}");
    }
    assert_eq!(found(GroupedPso { elite: false, second_stage: false, ..base }).evaluations, 50 + 30 * 50);
}
