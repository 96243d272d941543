//! From a path and limits to the fastest motion: grid, solution, check, refinement.

use super::bisection;
use super::check::{self, Use};
use super::course::Course;
use super::grid::Grid;
use super::kernel::SETTLED;
use super::limits::Bounds;
use super::motion::{Leg, legs};
use super::problem::{Accelerations, Demands, Problem};
use super::refuse;
use super::strips::{Strips, Stuck};
use super::windows::{Window, arrival, delay};
use super::{Report, TopMethod, TopOptions};
use crate::error::PlanError;

/// Intervals of the first grid, and from where on a grid is not refined: in all, and per polynomial piece of the path where there are many.
const FIRST: [usize; 2] = [160, 12];
const MOST: [usize; 2] = [4000, 100];
/// Rounds of refinement, of tightening, of tangents to the square root.
const ROUNDS: usize = 7;
const TIGHTENINGS: usize = 30;
/// Most parts that an interval is cut into at once, and what is added to their number before it is rounded down.
const MOST_PARTS: f64 = 6.0;
const AHEAD: f64 = 0.7;
/// Share of the change of the squared speed by a jump of the path acceleration, on the intervals beside it, that a finer grid might save.
const JUMP: f64 = 0.125;
/// Excess that is removed by slowing the whole motion down, where it starts and ends at rest.
const SMALL: f64 = 2e-5;
const TANGENTS: usize = 30;
/// Bisections of a speed at the end that is too high.
const HALVINGS: usize = 30;
/// Excess over a limit that tightening aims below.
const CLEAN: f64 = 2e-7;
/// Places per interval of the checks before the last one.
const FEW: usize = 6;

/// A profile on a grid, and how it was found.
pub(super) struct Solved {
    pub problem: Problem,
    pub x: Vec<f64>,
    pub legs: Vec<Leg>,
    pub used: Vec<Use>,
    pub report: Report,
}

/// A profile on which the use of all limits is known.
struct Checked {
    x: Vec<f64>,
    count: usize,
    legs: Vec<Leg>,
    used: Vec<Use>,
}

pub(super) struct Solver<'a, 'd> {
    pub course: &'a Course,
    pub bounds: &'a Bounds,
    pub options: &'a TopOptions,
    pub demands: &'a mut Demands<'d>,
}

impl Solver<'_, '_> {
    pub fn solve(&mut self) -> Result<Solved, PlanError> {
        let turns = self.demands.rows.is_some() || self.bounds.acceleration != self.bounds.deceleration;
        let at_least = |[all, each]: [usize; 2]| all.max(each * self.course.count());
        let mut report = Report::default();
        let mut grid = match self.options.grid {
            Some(count) => Grid::even(self.course, count, turns),
            None => Grid::initial(self.course, at_least(FIRST), turns),
        };
        let mut problem = self.discretise(&grid, &mut report, None)?;
        let mut x = self.fastest(&problem, None)?;
        for _ in 0..if self.options.grid.is_some() { 0 } else { ROUNDS } {
            let cuts = refinement(&problem, &x, self.bounds, self.options.tolerance);
            if cuts.iter().all(Vec::is_empty) || grid.spans.len() >= at_least(MOST) {
                break;
            }
            problem.bend = bends(&problem.s, &x, &problem.bend);
            let finer = grid.split(self.course, &cuts);
            let mut next = self.discretise(&finer, &mut report, Some((&problem, &grid)))?;
            next.bend = inherited(&problem, &next.s);
            (grid, problem) = (finer, next);
            x = self.fastest(&problem, None)?;
            report.refinements += 1;
        }
        problem.bend = bends(&problem.s, &x, &problem.bend);
        x = if let Ok(x) = self.fastest(&problem, Some(&x)) {
            x
        } else {
            // Slopes that fit the profile before may leave none: without them there is one.
            problem.bend.fill(0.0);
            self.fastest(&problem, Some(&x))?
        };
        let windows = self.wait(&mut problem, &mut x)?;
        let (legs, used) = self.tighten(&grid, &mut problem, &mut x, &mut report)?;
        for window in windows {
            window.met(arrival(&problem, &x, window.s).max(window.earliest))?;
        }
        Ok(Solved { problem, x, legs, used, report })
    }

    /// Slows the motion down where it would be early; returns the windows in the order of their places.
    fn wait(&self, problem: &mut Problem, x: &mut Vec<f64>) -> Result<Vec<Window>, PlanError> {
        if self.options.jerk {
            return Ok(Vec::new());
        }
        let length = self.course.length;
        let mut windows: Vec<Window> = self.options.windows.iter().map(|w| Window { s: w.s.min(length), ..*w }).collect();
        windows.sort_by(|a, b| a.s.total_cmp(&b.s));
        let mut from = 0.0;
        for window in &windows {
            let early = window.earliest / arrival(problem, x, window.s);
            let whole = window.s == length && from == 0.0 && self.ends() == [0.0; 2] && self.demands.rows.is_none();
            if whole && early > 1.0 {
                let factor = 1.0 / (early * early);
                x.iter_mut().chain(&mut problem.bend).chain(&mut problem.ceiling).for_each(|x| *x *= factor);
            } else {
                delay(problem, x, from, window, |problem| self.fastest(problem, None))?;
            }
            from = window.s;
        }
        Ok(windows)
    }

    fn discretise(&mut self, grid: &Grid, report: &mut Report, before: Option<(&Problem, &Grid)>) -> Result<Problem, PlanError> {
        report.points += grid.spans.len() + 1;
        Problem::new(self.course, grid, self.bounds, self.demands, before)
    }

    fn ends(&self) -> [f64; 2] {
        [self.options.start_speed * self.options.start_speed, self.options.end_speed * self.options.end_speed]
    }

    /// The fastest profile of a discretised problem.
    fn fastest(&self, problem: &Problem, from: Option<&[f64]>) -> Result<Vec<f64>, PlanError> {
        let ends = self.ends();
        let explain = |strips: &Strips, stuck: Stuck| refuse::explain(problem, strips, stuck, (self.bounds, &self.demands.names));
        if self.options.method == TopMethod::Bisection {
            let strips = capped(problem, problem.strips(self.bounds, None))?;
            return self
                .within(ends, |ends| bisection::fastest(problem, &strips.ceiling, self.bounds, ends))
                .map_err(|stuck| explain(&strips, stuck));
        }
        let solve = |x: Option<&[f64]>| {
            let strips = capped(problem, problem.strips(self.bounds, x))?;
            self.within(ends, |ends| strips.fastest(ends)).map_err(|stuck| explain(&strips, stuck))
        };
        let mut x = solve(from)?;
        if problem.viscous() {
            for _ in 0..TANGENTS {
                let next = solve(Some(&x))?;
                let change = next.iter().zip(&x).map(|(a, b)| (a - b).abs() / (a + b + f64::MIN_POSITIVE)).fold(0.0, f64::max);
                x = next;
                if change < SETTLED {
                    break;
                }
            }
        }
        Ok(x)
    }

    /// A profile between squared speeds at the ends. With limits of jerk speeds that are too high are lowered as far as it takes: it is but a guide then, and
    /// the jerk-limited version finds its own largest speeds.
    fn within(&self, mut ends: [f64; 2], solve: impl Fn([f64; 2]) -> Result<Vec<f64>, Stuck>) -> Result<Vec<f64>, Stuck> {
        let mut found = solve(ends);
        for _ in 0..if self.options.jerk { 3 } else { 0 } {
            let Err(stuck) = &found else { break };
            match stuck.boundary {
                Some([low, high]) => {
                    let end = &mut ends[usize::from(stuck.node > 0)];
                    if *end < low {
                        break;
                    }
                    *end = high;
                }
                None if ends[1] > 0.0 => {
                    let passes = |end: f64| !matches!(solve([ends[0], end]), Err(Stuck { boundary: None, .. }));
                    let (mut low, mut high) = (0.0, ends[1]);
                    for _ in 0..HALVINGS {
                        let middle = 0.5 * (low + high);
                        *(if passes(middle) { &mut low } else { &mut high }) = middle;
                    }
                    ends[1] = low;
                }
                None => break,
            }
            found = solve(ends);
        }
        found
    }

    /// The use of all limits at `count` places of every interval; intervals on which the profile is that of a check `before` keep its use.
    fn check(&mut self, grid: &Grid, problem: &Problem, x: &[f64], count: usize, before: Option<Checked>) -> Result<Checked, PlanError> {
        let legs = legs(&problem.s, x, &problem.bend);
        let before = before.filter(|before| before.count == count);
        let changed = |k: &usize| before.as_ref().is_none_or(|before| before.x[*k..k + 2] != x[*k..k + 2]);
        let which: Vec<usize> = (0..legs.len()).filter(changed).collect();
        let mut used = before.map_or_else(|| vec![Use::default(); legs.len()], |before| before.used);
        check::joints(self.course, grid, self.bounds, (&legs, &which), count, &mut used);
        check::demands(self.demands, &problem.s, (&legs, &which), count, &mut used)?;
        Ok(Checked { x: x.to_vec(), count, legs, used })
    }

    /// Tightens the limits of intervals on which the dense check finds an excess, until there is none; at last the whole motion is slowed down by what
    /// is left.
    fn tighten(&mut self, grid: &Grid, problem: &mut Problem, x: &mut Vec<f64>, report: &mut Report) -> Result<(Vec<Leg>, Vec<Use>), PlanError> {
        let full = self.options.check;
        let mut places = full.min(FEW);
        let scales = self.ends() == [0.0; 2] && self.demands.rows.is_none();
        if self.options.jerk {
            let legs = legs(&problem.s, x, &problem.bend);
            return Ok((legs, vec![Use::default(); problem.bend.len()]));
        }
        let mut checked = self.check(grid, problem, x, places, None)?;
        report.first_excess = excess(&checked.used);
        if self.options.grid.is_some() && !self.options.tighten {
            report.excess = report.first_excess;
            return Ok((checked.legs, checked.used));
        }
        for round in 0..TIGHTENINGS {
            if round == TIGHTENINGS / 3 {
                places = full;
            }
            let most = excess(&checked.used);
            if most <= CLEAN || (most <= SMALL && scales) {
                if places == full {
                    break;
                }
                places = full;
            } else {
                report.tightenings += 1;
                tighter(problem, x, &checked.used);
                *x = self.fastest(problem, Some(x))?;
            }
            checked = self.check(grid, problem, x, places, Some(checked))?;
        }
        if scales {
            if places < full {
                checked = self.check(grid, problem, x, full, Some(checked))?;
            }
            let factor = checked.used.iter().map(|u| u.rows.max(u.speed)).fold(1.0, f64::max) * (1.0 + 1e-9);
            if excess(&checked.used) > CLEAN {
                x.iter_mut().chain(&mut problem.bend).for_each(|x| *x /= factor);
                report.slowed = factor.sqrt();
                // Slower as a whole: every share falls by the factor.
                checked.used.iter_mut().for_each(|used| *used = used.slowed(factor));
                checked.legs = legs(&problem.s, x, &problem.bend);
            }
        }
        report.excess = excess(&checked.used);
        if report.excess > 1e-6 {
            let detail = format!("a limit is exceeded by {:.1e} of its size between grid points", report.excess);
            return Err(PlanError::CertificateFailed { stage: "timing of the joints", detail });
        }
        Ok((checked.legs, checked.used))
    }
}

/// Tightens the limits of the intervals on which they are exceeded.
fn tighter(problem: &mut Problem, x: &[f64], used: &[Use]) {
    for (k, used) in used.iter().enumerate() {
        if used.rows > 1.0 + 0.5 * CLEAN {
            problem.tightened[k] *= 1.0 + 1.1 * (used.rows - 1.0);
        }
        if used.speed > 1.0 + 0.5 * CLEAN {
            for node in [k, k + 1].into_iter().filter(|node| *node > 0 && *node < x.len() - 1) {
                problem.ceiling[node] = problem.ceiling[node].min(x[node] / used.speed);
            }
        }
    }
}

/// The largest excess over a limit, as a share of it.
fn excess(used: &[Use]) -> f64 {
    used.iter().map(|u| (u.rows - 1.0).max(u.speed.sqrt() - 1.0)).fold(0.0, f64::max)
}

/// Finite ceilings where no limit of speed binds: a thousand times what the largest acceleration at rest would reach over the whole path.
fn capped(problem: &Problem, mut strips: Strips) -> Result<Strips, PlanError> {
    if strips.ceiling.iter().all(|x| x.is_finite()) {
        return Ok(strips);
    }
    let most = (0..strips.reach.len()).map(|k| strips.accelerations(k, 0.0)).flat_map(|[low, high]| [low.abs(), high.abs()]).fold(0.0, f64::max);
    let length = problem.s[problem.s.len() - 1];
    let cap = 1e3 * 2.0 * most * length;
    if !cap.is_finite() {
        return Err(PlanError::bad("limits", "none that binds", "limits that bound the acceleration or the speed everywhere on the path"));
    }
    strips.ceiling.iter_mut().for_each(|x| *x = x.min(cap));
    Ok(strips)
}

/// Slopes of the path acceleration on the intervals of a profile: the smaller of those to the neighbours, none across switches and near rest.
fn bends(s: &[f64], x: &[f64], bend: &[f64]) -> Vec<f64> {
    let n = bend.len();
    let step = |k: usize| s[k + 1] - s[k];
    // In the middle of each interval.
    let u: Vec<f64> = (0..n).map(|k| (x[k + 1] - x[k]) / (2.0 * step(k))).collect();
    let slope = |k: usize| 2.0 * (u[k + 1] - u[k]) / (step(k) + step(k + 1));
    let mut out = vec![0.0; n];
    for k in 1..n.saturating_sub(1) {
        let (left, right) = (slope(k - 1), slope(k));
        let least = x[k].min(x[k + 1]);
        let most = 0.5 * least / (step(k) * step(k));
        if left * right > 0.0 && x[k - 1] > 0.0 && x[k + 2] > 0.0 {
            out[k] = left.signum() * left.abs().min(right.abs()).min(most);
        }
    }
    out
}

/// Slopes on a refined grid: those of the intervals that were cut.
fn inherited(before: &Problem, s: &[f64]) -> Vec<f64> {
    let parent = |middle: f64| before.s.partition_point(|a| *a <= middle).clamp(1, before.bend.len()) - 1;
    s.windows(2).map(|w| before.bend[parent(0.5 * (w[0] + w[1]))]).collect()
}

/// Where intervals should be cut: where limits are left unused, at the switch where one falls inside, else evenly.
fn refinement(problem: &Problem, x: &[f64], bounds: &Bounds, tolerance: f64) -> Vec<Vec<f64>> {
    let (s, bend, n) = (&problem.s, &problem.bend, problem.bend.len());
    let step = |k: usize| s[k + 1] - s[k];
    let u: Vec<f64> = (0..n).map(|k| (x[k + 1] - x[k]) / (2.0 * step(k))).collect();
    let time = |k: usize| 2.0 * step(k) / (x[k].sqrt() + x[k + 1].sqrt()).max(f64::MIN_POSITIVE);
    let total: f64 = (0..n).map(time).sum();
    // Path acceleration at the start and the end of an interval.
    let at = |k: usize, side: f64| u[k] + 0.5 * side * bend[k] * step(k);
    let (mut own, mut limits) = (Accelerations::default(), Vec::new());
    // By how much the path acceleration jumps at a node.
    let jump = |k: usize| if k == 0 || k == n { 0.0 } else { (at(k - 1, 1.0) - at(k, -1.0)).abs() };
    let unsteady = |k: usize| (JUMP * step(k) * (jump(k) + jump(k + 1)) / x[k].max(x[k + 1]).max(f64::MIN_POSITIVE)).min(1.0);
    let losses: Vec<f64> = (0..n).map(|k| time(k) * (0.5 * problem.slack(k, bounds, x, (&mut own, &mut limits))).max(unsteady(k))).collect();
    let sum: f64 = losses.iter().sum();
    let mut cuts = vec![Vec::new(); n];
    if sum <= tolerance * total {
        return cuts;
    }
    // What an interval loses falls with the cube of its length: this many parts for each leave the tolerance in all, with the fewest intervals.
    let share = (losses.iter().map(|l| l.cbrt()).sum::<f64>() / (tolerance * total)).sqrt();
    let parts: Vec<f64> = losses.iter().map(|l| (share * l.cbrt() + AHEAD).floor().min(MOST_PARTS)).collect();
    for k in (0..n).filter(|k| parts[*k] >= 2.0) {
        let [a, b] = [s[k], s[k + 1]];
        if k > 0 && k + 1 < n && (u[k - 1] - u[k]) * (u[k] - u[k + 1]) > 0.0 {
            // Where the line from the left meets the line from the right.
            let (left, right) = (at(k - 1, 1.0), at(k + 1, -1.0));
            let meet = (x[k + 1] - x[k] - 2.0 * right * (b - a)) / (2.0 * (left - right)) + a;
            if meet > a + 0.02 * (b - a) && meet < b - 0.02 * (b - a) {
                // A switch predicted near one end may be anywhere: the longer part is halved too.
                let (before, after) = (meet - a, b - meet);
                let halved = if before > 3.0 * after { Some(a + 0.5 * before) } else { None };
                cuts[k].extend(halved);
                cuts[k].push(meet);
                cuts[k].extend(if after > 3.0 * before { Some(b - 0.5 * after) } else { None });
                continue;
            }
        }
        cuts[k].extend((1..parts[k] as usize).map(|i| a + (b - a) * i as f64 / parts[k]));
    }
    cuts
}
