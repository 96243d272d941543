//! The colony on the corner graph: generations there and back, with what they learn on the way.

use super::super::crew::{Crew, March, best_of, better};
use super::super::improved::cone::Cone;
use super::super::improved::labour::{self, Role, Signs};
use super::super::pheromone::Pheromone;
use super::super::roads::Roads;
use super::super::rule::{Choices, Heuristic, Rule};
use super::super::walk::{Legs, Trail};
use super::Settings;
use super::corners::{Corners, GOAL, START};
use super::tails::{Learned, Tails};
use crate::context::{Context, Stop, stream};
use crate::plan::score::Aim;
use rand_chacha::ChaCha8Rng;

/// Nodes that an ant of the first generation may visit; twice as many in each further one until one arrives.
const FIRST: usize = 512;

/// A walk: every node in the order of the visits, and the way if the ant arrived.
struct Walk {
    been: Vec<u32>,
    trail: Option<Trail>,
}

/// A colony at work.
pub(super) struct Run<'a> {
    settings: &'a Settings,
    pub roads: &'a Corners<'a>,
    crew: Crew<'a, Corners<'a>>,
    pub tau: Pheromone<'a>,
    /// Of soldiers (and plain ants) and of kings.
    choices: [Choices; 2],
    roles: Vec<Role>,
    tails: Option<Tails>,
    pub best: Option<Trail>,
    /// Nodes that an ant may visit.
    patience: usize,
    rounds: u64,
    pub restarts: u32,
}

impl<'a> Run<'a> {
    pub fn new(settings: &'a Settings, roads: &'a Corners<'a>, ctx: &Context) -> Self {
        let crew = Crew::new(roads, Aim::Shortest, true, 0, ctx);
        let tau = match settings.cone {
            None => Pheromone::new(roads, |_| settings.initial, settings.evaporation, settings.bounds),
            Some((reading, mean)) => {
                let cone = Cone::new(roads, reading, [START, GOAL], roads.side());
                let scale = mean / cone.mean(roads);
                Pheromone::new(roads, move |node| scale * cone.strength(roads.position(node)), settings.evaporation, settings.bounds)
            }
        };
        let choices = [Role::Soldier, Role::King].map(|role| Choices::new(roads, settings.rule(role, 0.0), GOAL).with_focus(settings.focus));
        let roles = if settings.labour.is_some() { labour::roles(settings.ants) } else { vec![Role::Soldier; settings.ants] };
        let tails = settings.learning.then(|| Tails::new(roads));
        Self { settings, roads, crew, tau, choices, roles, tails, best: None, patience: FIRST, rounds: 1, restarts: 0 }
    }

    /// Runs to the end; `cost` is what the best way so far is worth to the caller, m.
    pub fn run(&mut self, ctx: &mut Context, cost: impl Fn(Option<&Trail>) -> f64) -> Stop {
        let first = ctx.iterations();
        self.rounds = ctx.budget().iterations.map_or(self.settings.iterations, |n| n.saturating_sub(first)).max(1);
        let mut still = 0;
        for number in 0..self.rounds {
            let before = self.length();
            for back in [false, true] {
                if let Err(stop) = self.half(back, number, 2 * (first + number) + u64::from(back), ctx) {
                    return stop;
                }
            }
            still = if self.length() < before || self.best.is_none() { 0 } else { still + 1 };
            if let Some(stop) = ctx.tick(cost(self.best.as_ref())) {
                return stop;
            }
            if still >= self.settings.patience {
                break;
            }
            self.restart();
        }
        Stop::Converged
    }

    fn length(&self) -> f64 {
        self.best.as_ref().map_or(f64::INFINITY, |t| t.length)
    }

    /// Half an iteration: there, or back.
    fn half(&mut self, back: bool, round: u64, number: u64, ctx: &mut Context) -> Result<(), Stop> {
        let (from, to) = if back { (GOAL, START) } else { (START, GOAL) };
        let progress = round as f64 / self.rounds as f64;
        for (choices, role) in self.choices.iter_mut().zip([Role::Soldier, Role::King]) {
            choices.renew(self.settings.rule(role, progress), to);
        }
        let march = March { ants: self.settings.ants, from, number };
        let walks = self.crew.march(&march, ctx, |ant, legs, rng| self.walk(self.roles[ant], legs, rng))?;
        self.learn(&walks);
        let (trails, weights): (Vec<Trail>, Vec<f64>) =
            walks.into_iter().zip(&self.roles).filter_map(|(walk, role)| Some((walk.trail?, role.weight()))).unzip();
        let found = best_of(&trails).cloned().map(|t| if back { t.reversed(self.roads) } else { t });
        self.best = better(self.best.take(), found.as_ref());
        if let Some(tails) = self.tails.as_ref().filter(|t| t.rest(START, GOAL).min(t.rest(GOAL, START)) < self.length()) {
            self.best = better(self.best.take(), tails.best(self.roads).as_ref());
        }
        if self.best.is_none() {
            self.patience = (2 * self.patience).min(8 * self.roads.count().max(FIRST));
        }
        self.tau.evaporate();
        let elite = self.best.iter().filter(|_| self.settings.elitist);
        for (trail, weight) in trails.iter().chain(elite).zip(weights.into_iter().chain([1.0])) {
            self.crew.mark(&mut self.tau, trail, weight * self.settings.deposit / trail.length.max(1.0));
        }
        self.convert(&trails, progress, &mut stream(ctx.seed(), number, u64::from(u32::MAX)));
        Ok(())
    }

    /// One ant: by the rule, back out of dead ends that nobody knows a way out of, past no node that only longer ways than the best lead over.
    fn walk(&self, role: Role, legs: &mut Legs, rng: &mut ChaCha8Rng) -> Walk {
        let choices = &self.choices[usize::from(role == Role::King)];
        let (target, most) = (choices.target(), self.length() * (1.0 + 1e-12));
        let learned = Learned { roads: self.roads, tails: self.tails.as_ref() };
        let shut = |node: u32| self.roads.distance(START, node) + self.roads.distance(node, GOAL) > most;
        let mut been = vec![legs.here()];
        for _ in 0..self.patience {
            if legs.here() == target {
                return Walk { been, trail: Some(legs.trail(self.roads, true, Aim::Shortest)) };
            }
            if legs.step(&learned, &self.tau, choices, shut, rng) {
                been.push(legs.here());
            } else if self.tails.as_ref().is_some_and(|t| t.rest(legs.here(), target).is_finite()) || !legs.roll_back() {
                break;
            }
        }
        Walk { been, trail: None }
    }

    /// In the order of the ants, so that threads change nothing.
    fn learn(&mut self, walks: &[Walk]) {
        let Some(tails) = &mut self.tails else { return };
        for walk in walks {
            if let Some(trail) = &walk.trail {
                tails.finished(trail);
            }
            tails.visited(self.roads, &walk.been);
        }
    }

    /// Changes roles, where there are any.
    fn convert(&mut self, trails: &[Trail], progress: f64, rng: &mut ChaCha8Rng) {
        let Some(conversion) = self.settings.labour else { return };
        let lengths: Vec<f64> = trails.iter().map(|t| t.length).collect();
        let [mean, deviation] = labour::statistics(&lengths, self.settings.ants);
        let signs = Signs { progress, mean, deviation, entropy: self.entropy() };
        labour::convert(&mut self.roles, conversion, &signs, rng);
    }

    /// Entropy of the choices along the best way, 0 to 1.
    fn entropy(&mut self) -> f64 {
        let Some(best) = &self.best else { return 1.0 };
        self.choices[0].renew(self.settings.rule(Role::Soldier, 0.0), GOAL);
        let learned = Learned { roads: self.roads, tails: self.tails.as_ref() };
        best.nodes.iter().map(|node| self.choices[0].entropy(&learned, &self.tau, *node)).sum::<f64>() / best.nodes.len() as f64
    }

    /// Begins anew when the choices along the best way are decided.
    fn restart(&mut self) {
        if self.settings.restart > 0.0 && self.best.is_some() && self.entropy() < self.settings.restart {
            self.tau.restart();
            self.restarts += 1;
        }
    }
}

impl Settings {
    /// The rule of a role after a share of the iterations.
    fn rule(&self, role: Role, share: f64) -> Rule {
        let at = |[a, b]: [f64; 2]| a + (b - a) * share * share;
        let plain = Rule { alpha: at(self.alpha), beta: at(self.beta), heuristic: Heuristic::Detour, greedy: 0.0, uniform: 0.0 };
        if self.labour.is_some() { role.rule(plain) } else { plain }
    }
}
