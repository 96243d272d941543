//! Outside the guaranteed domain: the start acceleration is negative or the end acceleration positive.
//!
//! Every candidate is a prefix that drives the acceleration to some extreme, holds it for a while, and the fastest velocity
//! transition from there. A bump (prefix upwards) covers more than the direct transition, a dip (prefix downwards) can cover less.

use super::transition::{Builder, State1, transition};
use super::{Bounds, Profile, SCurve, advance, infeasible};
use crate::error::PlanError;

/// Steps of the scan for a dip.
const SCAN: usize = 400;

/// The fastest profile of the family.
pub(super) fn plan(problem: &SCurve) -> Result<Profile, PlanError> {
    let (start, end, bounds) = (State1::from(problem.start), State1::from(problem.end), &problem.bounds);
    let direct = transition(start, end, bounds).ok_or_else(|| infeasible("an acceleration at the ends is outside the limits".into()))?;
    let reach = length(&direct);
    let slack = 1e-12 * reach.abs().max(problem.distance);
    let found = if (problem.distance - reach).abs() <= slack {
        Some(direct)
    } else if problem.distance > reach {
        bump(problem)
    } else {
        dip(problem)
    };
    match found.filter(|p| admissible(p, bounds.speed)) {
        Some(profile) => Ok(profile),
        None => Err(problem.too_short()),
    }
}

/// Distance of a profile, m.
fn length(profile: &Profile) -> f64 {
    profile.at(f64::INFINITY).0
}

/// Prefix `u` seconds long towards the limit of `sign`, then the fastest transition.
fn candidate(problem: &SCurve, sign: f64, u: f64) -> Option<Profile> {
    let (bounds, (v, a)) = (&problem.bounds, problem.start);
    let limit = if sign > 0.0 { bounds.acceleration } else { -bounds.deceleration };
    let mut builder = Builder::default();
    let to = ramped(a, sign, u, bounds);
    builder.ramp(a, to, bounds);
    let ramp = builder.finish(problem.start.into());
    let spent = ramp.duration();
    if to == limit && u > spent {
        builder.push(u - spent, 0.0);
    }
    let prefix = builder.finish((v, a).into());
    let (_, v1, a1, _) = prefix.at(f64::INFINITY);
    builder.extend(&transition((v1, a1).into(), problem.end.into(), bounds)?);
    Some(builder.finish((v, a).into()))
}

/// Acceleration after `u` seconds of ramp from `a` in the direction `sign`, at most the limit.
fn ramped(a: f64, sign: f64, u: f64, bounds: &Bounds) -> f64 {
    let j = &bounds.jerk;
    let (first, second, limit) = if sign > 0.0 { (j.unbrake, j.build, bounds.acceleration) } else { (j.release, j.brake, bounds.deceleration) };
    let x = sign * a;
    let to_zero = (-x).max(0.0) / first;
    let y = if u < to_zero { x + first * u } else { x.max(0.0) + second * (u - to_zero) };
    sign * y.min(limit)
}

/// Longest prefix that can be of use: the ramp, and a hold through the whole range of speeds.
fn longest(problem: &SCurve, sign: f64) -> f64 {
    let Bounds { speed, acceleration, deceleration, jerk } = problem.bounds;
    let limit = if sign > 0.0 { acceleration } else { deceleration };
    let slowest = jerk.build.min(jerk.release).min(jerk.brake).min(jerk.unbrake);
    (acceleration + deceleration) / slowest + 2.0 * speed / limit
}

/// More distance than the direct transition: up first; cruise at the speed limit if it is reached.
fn bump(problem: &SCurve) -> Option<Profile> {
    if let Some((up, down)) = at_limit(problem) {
        let rest = problem.distance - length(&up) - length(&down);
        if rest >= 0.0 {
            let mut builder = Builder::default();
            builder.extend(&up);
            builder.push(rest / problem.bounds.speed, 0.0);
            builder.extend(&down);
            return Some(builder.finish(problem.start.into()));
        }
    }
    let reach = |u: f64| candidate(problem, 1.0, u).map(|p| length(&p));
    bisect(problem, 1.0, (0.0, longest(problem, 1.0)), reach)
}

/// The transitions to and from the speed limit.
fn at_limit(problem: &SCurve) -> Option<(Profile, Profile)> {
    let top = State1 { v: problem.bounds.speed, a: 0.0 };
    let up = transition(problem.start.into(), top, &problem.bounds)?;
    Some((up, transition(top, problem.end.into(), &problem.bounds)?))
}

/// Less distance than the direct transition: down first. The time grows with the depth, so the first depth that fits is the best.
fn dip(problem: &SCurve) -> Option<Profile> {
    let reach = |u: f64| candidate(problem, -1.0, u).map(|p| length(&p));
    let most = longest(problem, -1.0);
    let mut before = 0.0;
    for i in 1..=SCAN {
        let u = most * (i as f64 / SCAN as f64).powi(2);
        if reach(u)? <= problem.distance {
            return bisect(problem, -1.0, (before, u), reach);
        }
        before = u;
    }
    None
}

/// Bisection on the length of the prefix.
fn bisect(problem: &SCurve, sign: f64, (mut lo, mut hi): (f64, f64), reach: impl Fn(f64) -> Option<f64>) -> Option<Profile> {
    for _ in 0..200 {
        let mid = f64::midpoint(lo, hi);
        if mid <= lo || mid >= hi {
            break;
        }
        let over = reach(mid)? > problem.distance;
        if over == (sign > 0.0) { hi = mid } else { lo = mid }
    }
    let profile = candidate(problem, sign, lo)?;
    ((length(&profile) - problem.distance).abs() <= 1e-9 * problem.distance.max(1.0)).then_some(profile)
}

/// No reversal and no overspeed anywhere.
fn admissible(profile: &Profile, speed: f64) -> bool {
    let slack = 1e-9 * speed;
    let mut state = (0.0, profile.start.0, profile.start.1);
    for phase in profile.phases() {
        let next = advance(state, phase.jerk, phase.duration);
        let mut extremes = [next.1, next.1];
        if state.2 * next.2 < 0.0 {
            extremes[1] = state.1 - 0.5 * state.2 * state.2 / phase.jerk;
        }
        if extremes.iter().any(|v| *v < -slack || *v > speed + slack) {
            return false;
        }
        state = next;
    }
    true
}
