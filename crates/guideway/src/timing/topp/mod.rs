//! Time-optimal motion along a path under limits of joint speed and acceleration and any limit of the form
//! `low <= a u + b x + d sqrt(x) + c <= high` in the path acceleration `u` and the squared path speed `x`, torque for one.
//!
//! Sources: reachability analysis of \[pham2018\], bisection of \[barnett2021\]; departures in docs/methods/topp.md. The path parameter is the arc length in
//! joint space, rad.

mod bisection;
mod check;
mod course;
mod grid;
mod kernel;
mod limits;
mod motion;
mod problem;
mod refuse;
mod rows;
mod smooth;
mod solve;
mod strips;
mod table;
#[cfg(test)]
mod tests;
mod windows;

pub use kernel::kernel;
pub use limits::{JointLimits, PerJoint};
pub use motion::{JointMotion, JointState};
pub use problem::{CeilingAt, Demands, RowsAt};
pub use rows::Rows;
pub use windows::Window;

use crate::error::PlanError;
use crate::path::Path;
use crate::timing::Piece;
use check::Binding;
use course::Course;
use grid::Grid;
use serde::Serialize;
use smooth::{CEILING, Smooth, Task};
use solve::{Solved, Solver};
use table::Table;

/// Path speed, rad/s, below which an end is one at rest where the limits of jerk are kept.
const AT_REST: f64 = 1e-6;

/// How the profile on a grid is found.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum TopMethod {
    /// Controllable sets backward, greedily forward: exact on its grid.
    #[default]
    Reachability,
    /// Bisection on the speed, node by node.
    Bisection,
}

/// What a time-optimal motion is asked besides its limits.
#[derive(Debug, Clone, PartialEq)]
pub struct TopOptions {
    /// How.
    pub method: TopMethod,
    /// Path speed at the start, rad/s; the path acceleration there is free within the limits, also where those of jerk are kept. With them less than 1e-6 rad/s
    /// is rest.
    pub start_speed: f64,
    /// Path speed at the end, rad/s; likewise.
    pub end_speed: f64,
    /// Number of intervals of equal length; `None`: chosen so that the time lost by the grid is below `tolerance`.
    pub grid: Option<usize>,
    /// Time that the grid may cost, as a share of the duration (an estimate, see the docs).
    pub tolerance: f64,
    /// Places per interval at which all limits are checked.
    pub check: usize,
    /// When places may be passed; with limits of jerk only the end.
    pub windows: Vec<Window>,
    /// Whether the limits of jerk are kept too.
    pub jerk: bool,
    /// Whether limits are tightened on a fixed grid as well until the check passes.
    pub tighten: bool,
}

impl Default for TopOptions {
    fn default() -> Self {
        Self {
            method: TopMethod::default(),
            start_speed: 0.0,
            end_speed: 0.0,
            grid: None,
            tolerance: 3e-4,
            check: 20,
            windows: Vec::new(),
            jerk: false,
            tighten: true,
        }
    }
}

/// How a motion was found.
#[derive(Debug, Clone, Default, PartialEq, Serialize)]
pub struct Report {
    /// Grid points tried in all rounds.
    pub points: usize,
    /// Rounds in which the grid was refined.
    pub refinements: usize,
    /// Rounds in which limits were tightened between grid points.
    pub tightenings: usize,
    /// Largest excess over a limit before tightening, as a share of the limit, on the dense check.
    pub first_excess: f64,
    /// Largest excess of the result, as a share of the limit, on the dense check.
    pub excess: f64,
    /// Factor by which the whole motion was slowed down at last; 0: it was not.
    pub slowed: f64,
    /// Newton steps of the jerk-limited version.
    pub steps: usize,
    /// Rounds in which its limits were tightened.
    pub jerk_tightenings: usize,
    /// Largest factor by which a stretch of it was slowed down at last.
    pub jerk_slowed: f64,
}

/// The fastest motion along `path` under limits of its joints and `demands`.
/// # Errors
/// [`PlanError::Infeasible`] names the limit and the place, [`PlanError::BadParameter`] the value that is not allowed; what a callback raises.
pub fn time_joints(path: &Path, limits: &JointLimits, options: &TopOptions, demands: &mut Demands) -> Result<JointMotion, PlanError> {
    let bounds = limits.bounds(path.dimension())?;
    options.validate(path.length())?;
    let course = Course::new(path);
    if course.count() == 0 {
        let (active, mvc) = (vec![String::new()], vec![0.0]);
        let empty = JointMotion {
            path: path.clone(),
            s: vec![0.0],
            x: vec![0.0],
            u: vec![],
            active,
            mvc,
            pieces: vec![],
            price: vec![],
            report: Report::default(),
        };
        return Ok(empty);
    }
    let mut table = demands.rows.as_mut().map(|rows| Table::new(&course, &mut **rows)).transpose()?;
    let rates = demands.rates.as_mut().filter(|_| options.jerk).map(|rates| Table::new(&course, &mut **rates)).transpose()?;
    let demands = &mut Demands {
        names: demands.names.clone(),
        rate_names: demands.rate_names.clone(),
        rates: None,
        rows: table.as_mut().map(|table| Box::new(|s: &[f64]| table.at(s)) as Box<RowsAt>),
        ceiling: demands.ceiling.as_mut().map(|ceiling| Box::new(|s: &[f64]| ceiling(s)) as Box<CeilingAt>),
    };
    let solved = Solver { course: &course, bounds: &bounds, options, demands }.solve()?;
    let motion = told(path, &solved, &bounds, &demands.names);
    if !options.jerk {
        return Ok(motion);
    }
    if bounds.jerk.iter().all(|j| j.is_infinite()) && rates.is_none() {
        return Err(PlanError::bad("limits.jerk", "none", "a limit of jerk for at least one joint, rad/s3, or of rates"));
    }
    let breaks = grid::breaks(&course, true);
    let speeds = [options.start_speed, options.end_speed].map(|v| if v < AT_REST { 0.0 } else { v });
    let mut task = Task { course: &course, bounds: &bounds, demands, rates, breaks, cells: options.grid, check: options.check, speeds };
    // Places are found on spans of their own: where the path turns sharply those of a given grid are too long for it.
    let mut smooth = task.solve(&solved, &Grid::initial(&course, grid::WALK, false).spans)?;
    smooth.wait(&options.windows, path.length(), speeds)?;
    if !options.windows.is_empty() {
        task.again(&mut smooth)?;
        smooth.wait(&options.windows, path.length(), speeds)?;
    }
    Ok(smoothed(&motion, smooth, &bounds, (task.demands, speeds[1])))
}

/// The second-order motion with its pieces replaced by the jerk-limited ones.
fn smoothed(second: &JointMotion, smooth: Smooth, bounds: &limits::Bounds, (demands, end_speed): (&Demands, f64)) -> JointMotion {
    let mut motion = second.clone();
    let states: Vec<[f64; 3]> = smooth
        .pieces
        .iter()
        .filter_map(|p| if let Piece::Along { s, speed, acceleration, .. } = p { Some([*s, *speed, *acceleration]) } else { None })
        .collect();
    let end = second.s[second.s.len() - 1];
    motion.s = states.iter().map(|state| state[0]).chain([end]).collect();
    motion.x = states.iter().map(|state| state[1] * state[1]).chain([end_speed * end_speed]).collect();
    motion.u = states.iter().map(|state| state[2]).collect();
    motion.mvc = motion.s.iter().map(|s| second.mvc_at(*s)).collect();
    motion.pieces = smooth.pieces;
    let rate_name = |row: usize| demands.rate_names.get(row).cloned().unwrap_or_else(|| format!("rate of row {}", row + 1));
    let name = |k: usize| {
        let used = &smooth.used[(k / 2).min(smooth.used.len() - 1)];
        let kind = (0..5).max_by(|i, j| used.share[*i].total_cmp(&used.share[*j])).unwrap_or(0);
        match (kind, used.owner[kind]) {
            (0, CEILING) => "ceiling".to_owned(),
            (3, row) => row_name(&demands.names, row),
            (4, row) => rate_name(row),
            (kind, joint) => format!("{} of joint {}", ["speed", "acceleration", "jerk"][kind], joint + 1),
        }
    };
    motion.active = (0..motion.s.len()).map(name).collect();
    let all: f64 = smooth.prices.iter().sum();
    let lost = motion.duration() - second.duration();
    let price = |p: &f64| if all > 0.0 { lost * p / all } else { 0.0 };
    let (jerks, rates) = smooth.prices.split_at(bounds.jerk.len());
    let jerks = jerks.iter().enumerate().filter(|(i, _)| bounds.jerk[*i].is_finite());
    motion.price = jerks.map(|(i, p)| (format!("jerk of joint {}", i + 1), price(p))).collect();
    motion.price.extend(rates.iter().enumerate().map(|(r, p)| (rate_name(r), price(p))));
    motion.report.excess = smooth.used.iter().flat_map(|used| used.share).map(|share| share - 1.0).fold(0.0, f64::max);
    motion.report.steps = smooth.steps;
    motion.report.jerk_tightenings = smooth.tightenings;
    motion.report.jerk_slowed = smooth.slowed;
    motion
}

/// The name of a row that was called for.
fn row_name(names: &[String], row: usize) -> String {
    names.get(row).cloned().unwrap_or_else(|| format!("row {}", row + 1))
}

/// The solution with what binds where.
fn told(path: &Path, solved: &Solved, bounds: &limits::Bounds, names: &[String]) -> JointMotion {
    let (s, x) = (&solved.problem.s, &solved.x);
    let n = s.len() - 1;
    let name = |k: usize| match solved.used[k.min(n - 1)].binding {
        Binding::Speed(i) => format!("speed of joint {}", i + 1),
        Binding::Acceleration(i) => format!("acceleration of joint {}", i + 1),
        Binding::Row(i) => row_name(names, i),
        Binding::Ceiling => "ceiling".to_owned(),
    };
    let strips = solved.problem.strips(bounds, Some(x));
    let mvc = (0..=n).map(|k| strips.highest(k.min(n - 1)).unwrap_or(0.0).min(solved.problem.ceiling[k]));
    JointMotion {
        path: path.clone(),
        u: solved.legs.iter().map(|leg| leg.acceleration).collect(),
        active: (0..=n).map(name).collect(),
        mvc: mvc.collect(),
        pieces: motion::pieces(s, &solved.legs),
        s: s.clone(),
        x: x.clone(),
        price: Vec::new(),
        report: solved.report.clone(),
    }
}

impl TopMethod {
    /// From its name.
    /// # Errors
    /// [`PlanError::BadParameter`] names the valid ones.
    pub fn named(name: &str) -> Result<Self, PlanError> {
        match name {
            "reachability" => Ok(Self::Reachability),
            "bisection" => Ok(Self::Bisection),
            other => Err(PlanError::bad("method", other, "reachability or bisection")),
        }
    }
}

impl TopOptions {
    fn validate(&self, length: f64) -> Result<(), PlanError> {
        for (name, v) in [("start_speed", self.start_speed), ("end_speed", self.end_speed)] {
            if !(v >= 0.0 && v.is_finite()) {
                return Err(PlanError::bad(name, v, "a path speed >= 0, rad/s"));
            }
        }
        self.windows.iter().try_for_each(|window| window.validate(length))?;
        if !(self.tolerance > 0.0 && self.tolerance < 1.0) {
            return Err(PlanError::bad("tolerance", self.tolerance, "above 0, below 1"));
        }
        if let Some(n) = self.grid.filter(|n| !(2..=1_000_000).contains(n)) {
            return Err(PlanError::bad("grid", n, "2 to 1000000 intervals"));
        }
        if !(1..=1000).contains(&self.check) {
            return Err(PlanError::bad("check", self.check, "1 to 1000 places per interval"));
        }
        Ok(())
    }
}
