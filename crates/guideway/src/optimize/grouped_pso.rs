//! Grouped particle swarm with an elite group and a second, adaptive stage.
//!
//! Source: \[han2024\]. Particles are sorted and dealt like cards into subgroups, each of which follows its own best; copies of the subgroups' bests form an
//! elite group that follows the best of all. A particle that a plain step does not improve takes, from where it was, a step with adapted parameters.
//! Symbols: `NP` particles, `m_g` groups, `t_max` iterations, `omega, c1, c2` inertia, cognitive, social; `omega_min, omega_max` `inertia_range`;
//! `c_a1` runs through `cognitive_range` and `c_a2` through `social_range` as `t` grows.
//! Departures, where the source is silent: `m_g`, `c1`, `c2` and the limit on the speed; subgroups are dealt anew every `regroup` iterations, elite members
//! among them, the worst that are too many leave; the exploring second step is kept even where it is worse, own bests change on improvement only; a batch is
//! judged before bests change.

use super::flock::{Moves, Particle, Pull, Space, flock, positions};
use super::record::{Record, check, within};
use super::{Cost, Minimum, Objective, Optimizer, evaluate};
use crate::context::Context;
use crate::error::PlanError;
use serde::{Deserialize, Serialize};

/// Grouped particle swarm; every part of it is a switch.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct GroupedPso {
    /// Particles `NP` besides the elite, at least 2.
    pub particles: usize,
    /// Subgroups `m_g`, 1 to `particles`.
    pub groups: usize,
    /// Iterations `t_max`.
    pub iterations: u64,
    /// Stops once the best has been the same for that many iterations; 0: never.
    pub patience: u64,
    /// Subgroups are dealt anew after that many iterations; 0: never.
    pub regroup: u64,
    /// Elite group.
    pub elite: bool,
    /// Second, adaptive stage for particles that the first does not improve.
    pub second_stage: bool,
    /// Inertia `omega` of the first stage, 0 to 2.
    pub inertia: f64,
    /// Pull of the particle's own best place `c1` in the first stage, 0 to 10.
    pub cognitive: f64,
    /// Pull of the guide `c2` in the first stage, 0 to 10.
    pub social: f64,
    /// Inertia of the second stage, at the guide and farthest from it.
    pub inertia_range: [f64; 2],
    /// Pull of the own best place in the second stage, at first and in the end.
    pub cognitive_range: [f64; 2],
    /// Pull of the guide in the second stage, at first and in the end.
    pub social_range: [f64; 2],
    /// Largest step in each number, share of its range.
    pub speed: f64,
}

impl Default for GroupedPso {
    fn default() -> Self {
        Self {
            particles: 50,
            groups: 5,
            iterations: 50,
            patience: 20,
            regroup: 5,
            elite: true,
            second_stage: true,
            inertia: 0.5,
            cognitive: 1.5,
            social: 1.5,
            inertia_range: [0.4, 0.9],
            cognitive_range: [2.5, 0.5],
            social_range: [0.5, 2.5],
            speed: 0.2,
        }
    }
}

impl Optimizer for GroupedPso {
    fn minimize(&self, f: &dyn Objective, ctx: &mut Context) -> Result<Minimum, PlanError> {
        let plain = self.check(f)?;
        let record = Record::new(self.iterations, self.patience, ctx);
        let particles = flock(f, self.particles, self.speed, ctx)?;
        let space = Space { bounds: f.bounds(), speed: self.speed };
        let mut run = Run { method: self, f, particles, record, leaders: Vec::new(), moves: Moves::default(), space };
        run.particles.iter().for_each(|p| run.record.offer(&p.x, p.cost));
        run.deal();
        let stop = loop {
            let t = run.record.begin();
            let weak = run.first_stage(plain, ctx)?;
            if !weak.is_empty() {
                run.second_stage(&weak, t, ctx)?;
            }
            run.exchange();
            if let Some(stop) = run.record.tick(f, ctx) {
                break stop;
            }
            if self.regroup > 0 && t.is_multiple_of(self.regroup) {
                run.deal();
            }
        };
        let (xs, costs) = positions(run.particles);
        Ok(run.record.finish(stop, xs, costs, ctx))
    }
}

impl GroupedPso {
    fn check(&self, f: &dyn Objective) -> Result<Pull, PlanError> {
        check(f, "particles", self.particles, self.iterations)?;
        if !(1..=self.particles).contains(&self.groups) {
            return Err(PlanError::bad("groups", self.groups, format!("1 to {}, the particles", self.particles)));
        }
        for (name, range, most) in
            [("inertia_range", self.inertia_range, 2.0), ("cognitive_range", self.cognitive_range, 10.0), ("social_range", self.social_range, 10.0)]
        {
            range.iter().try_for_each(|&v| within(name, v, [0.0, most]))?;
        }
        Pull { inertia: self.inertia, own: self.cognitive, guide: self.social }.check()
    }

    /// Parameters of the second stage in iteration `t`, `share` of the way from the guide to the farthest of the subgroups' bests.
    fn adapted(&self, t: u64, share: f64) -> Pull {
        let along = |[a, b]: [f64; 2], r: f64| a + (b - a) * r;
        let r = (t as f64 / self.iterations as f64).min(1.0);
        Pull {
            inertia: along(self.inertia_range, share),                // omega_r
            own: along(self.cognitive_range, r * r),                  // c_a1
            guide: along(self.social_range, 1.0 - (1.0 - r).powi(2)), // c_a2
        }
    }
}

/// One run. The first `NP` particles are the subgroups' (`i % m_g` is the subgroup of the `i`-th), the others the elite.
struct Run<'a> {
    method: &'a GroupedPso,
    f: &'a dyn Objective,
    particles: Vec<Particle>,
    record: Record,
    /// The best particle of each subgroup.
    leaders: Vec<usize>,
    moves: Moves,
    space: Space<'a>,
}

impl Run<'_> {
    /// Sorts the particles, best first, deals them into the subgroups, and copies the best of each into the elite.
    fn deal(&mut self) {
        self.particles.sort_by(|a, b| a.best_cost.order(b.best_cost));
        self.particles.truncate(self.method.particles);
        if self.method.elite {
            let elite = self.particles[..self.method.groups].to_vec();
            self.particles.extend(elite);
        }
        self.leaders = (0..self.method.groups).collect();
    }

    /// The place that guides a particle.
    fn guide(&self, k: usize) -> &[f64] {
        match self.leaders.get(k % self.method.groups) {
            Some(&leader) if k < self.method.particles => &self.particles[leader].best,
            _ if self.record.best.is_empty() => &self.particles[k].best,
            _ => &self.record.best,
        }
    }

    /// A plain step of all; gives back those that it does not improve and that the second stage is for.
    fn first_stage(&mut self, plain: Pull, ctx: &mut Context) -> Result<Vec<usize>, PlanError> {
        let all: Vec<usize> = (0..self.particles.len()).collect();
        let costs = self.step(&all, |_| plain, ctx)?;
        let mut weak = Vec::new();
        for (k, cost) in costs.into_iter().enumerate() {
            if !self.method.second_stage || cost.beats(self.particles[k].cost) {
                self.moves.take(k, &mut self.particles[k], cost);
            } else {
                weak.push(k);
            }
        }
        Ok(weak)
    }

    /// A step with adapted parameters, from where the particles were; kept whether it improves or not.
    fn second_stage(&mut self, weak: &[usize], t: u64, ctx: &mut Context) -> Result<(), PlanError> {
        let pulls: Vec<Pull> = weak.iter().map(|&k| self.method.adapted(t, self.share(k))).collect();
        let costs = self.step(weak, |i| pulls[i], ctx)?;
        for (i, (&k, cost)) in weak.iter().zip(costs).enumerate() {
            self.moves.take(i, &mut self.particles[k], cost);
        }
        Ok(())
    }

    /// Costs of the next places of some particles, the `i`-th moved by `pull(i)`.
    fn step(&mut self, some: &[usize], pull: impl Fn(usize) -> Pull, ctx: &mut Context) -> Result<Vec<Cost>, PlanError> {
        let mut moves = std::mem::take(&mut self.moves);
        moves.clear();
        for (i, &k) in some.iter().enumerate() {
            moves.add(&self.particles[k], self.guide(k), pull(i), &self.space, &mut ctx.rng);
        }
        self.moves = moves;
        evaluate(self.f, self.moves.candidates(), ctx)
    }

    /// Distance of a particle to its guide, as a share of that to the farthest of the subgroups' bests.
    fn share(&self, k: usize) -> f64 {
        let square = |to: &[f64]| self.particles[k].x.iter().zip(to).map(|(a, b)| (a - b) * (a - b)).sum::<f64>();
        let own = square(self.guide(k));
        let most = self.leaders.iter().map(|&l| square(&self.particles[l].best)).fold(own, f64::max);
        if most > 0.0 { (own / most).sqrt() } else { 0.0 }
    }

    /// Finds the subgroups' bests. One that is better than the best of all takes its place, and that of the worst elite member.
    fn exchange(&mut self) {
        let (count, groups) = (self.method.particles, self.method.groups);
        let better = |p: &[Particle], a: usize, b: usize| if p[b].best_cost.beats(p[a].best_cost) { b } else { a };
        for group in 0..groups {
            let members = (group..count).step_by(groups);
            self.leaders[group] = members.fold(group, |a, b| better(&self.particles, a, b));
        }
        let top = self.leaders.iter().fold(self.leaders[0], |a, &b| better(&self.particles, a, b));
        if self.particles[top].best_cost.beats(self.record.cost) {
            let worst = (count..self.particles.len()).reduce(|a, b| if better(&self.particles, a, b) == b { a } else { b });
            if let Some(worst) = worst {
                self.particles[worst] = self.particles[top].clone();
            }
        }
        self.particles.iter().for_each(|p| self.record.offer(&p.best, p.best_cost));
    }
}
