//! Lines for candidates to follow, from exact routes, and how many control points they need.

use super::curves::Curves;
use super::settings::Settings;
use crate::Point;
use crate::context::Context;
use crate::error::PlanError;
use crate::optimize::{Cost, Objective};
use crate::plan::search::Visibility;
use crate::plan::{Planner, Solution};
use crate::query::Query;
use crate::refine::{Refiner, Smooth, polyline};
use crate::world::shape::{cross, distance, dot, sub};
use std::f64::consts::FRAC_PI_2;

/// Wider routes keep that much more than what is needed, in the larger of that and a cell.
const WIDER: [f64; 4] = [0.5, 0.2, 0.07, 0.02];
/// Wider routes may be longer by that share.
const DETOUR: f64 = 0.15;
/// As many wider routes are enough.
const ENOUGH: usize = 2;
/// More control points than that are not searched.
const MOST: usize = 160;
/// From so many control points on they stay near the route.
const MANY: usize = 8;
/// Control points are tried in numbers that grow by that factor.
const GROWTH: f64 = 1.5;
/// Copies of the best hint, each control point moved at random, and how far in distances of control points.
const COPIES: (u64, f64) = (6, 0.1);

/// Curves with their hints, and whether one of these is free (`None`: none was judged).
pub(in crate::plan::swarm) struct Layout {
    pub curves: Curves,
    pub free: Option<bool>,
}

/// The exact route and wider ones, smoothed and as they are; the exact one last.
pub(in crate::plan::swarm) fn lines(query: &Query, exact: &Solution, ctx: &mut Context) -> Vec<Vec<Point>> {
    let unit = query.radius().max(query.world.resolution());
    let mut lines = Vec::new();
    for share in WIDER {
        if lines.len() >= 2 * ENOUGH || ctx.poll().is_some() {
            break;
        }
        let wider = Query { clearance: query.clearance + share * unit, ..query.clone() };
        let Ok(found) = Visibility::default().plan(&wider, ctx) else { continue };
        if found.length() <= exact.length() * (1.0 + DETOUR) {
            if let Ok(smooth) = Smooth::default().refine(&found.path, &wider, ctx) {
                lines.push(polyline(&smooth.path, &wider));
            }
            lines.push(found.path.points());
        }
    }
    lines.push(exact.path.points());
    lines
}

/// Curves with the number of control points that is asked for, or, if it is left open, the least of some numbers with which a candidate along a line is free.
pub(in crate::plan::swarm) fn layout(query: &Query, settings: &Settings, lines: &[Vec<Point>], ctx: &mut Context) -> Result<Layout, PlanError> {
    let Some(exact) = lines.last() else {
        return Ok(Layout { curves: Curves::new(query, settings)?, free: None });
    };
    let legs = legs(query, exact);
    let mut growth = 1.0;
    loop {
        let counts = legs.iter().map(|&(length, bends)| {
            let points = if settings.points == 0 { (growth * (4 + bends) as f64).ceil() as usize } else { settings.points };
            (points, length)
        });
        let counts: Vec<(usize, f64)> = counts.collect();
        let total: usize = counts.iter().map(|c| c.0).sum();
        let mut curves = Curves::along(query, settings, &counts)?;
        let mut fits: Vec<(Cost, Vec<f64>)> = Vec::new();
        for line in lines {
            if ctx.poll().is_some() || ctx.budget().evaluations.is_some_and(|most| ctx.evaluations() + Curves::FITS > most) {
                break;
            }
            let x = curves.fit(line);
            ctx.count_evaluations(Curves::FITS);
            let cost = curves.judge(&x).cost();
            if !fits.iter().any(|f| f.1 == x) {
                fits.push((cost, x));
            }
        }
        fits.sort_by(|a, b| a.0.order(b.0));
        let free = fits.first().map(|f| f.0.feasible());
        growth *= GROWTH;
        if free == Some(true) || settings.points > 0 || total as f64 * GROWTH > MOST as f64 || ctx.poll().is_some() {
            seed(&mut curves, settings, fits.into_iter().map(|f| f.1).collect(), ctx.seed())?;
            return Ok(Layout { curves, free });
        }
    }
}

/// Sets hints and, for many control points, a box around the best.
pub(in crate::plan::swarm) fn seed(curves: &mut Curves, settings: &Settings, mut fits: Vec<Vec<f64>>, seed: u64) -> Result<(), PlanError> {
    if !settings.hints {
        return Ok(());
    }
    let Some(best) = fits.first().cloned() else { return Ok(()) };
    let control = curves.control(&best);
    let spacing = control.windows(2).map(|w| distance(w[0], w[1])).sum::<f64>() / (control.len() - 1) as f64;
    let numbers = 2 * curves.points();
    if curves.points() > MANY {
        let narrow = |(i, b): (usize, &(f64, f64))| {
            let around = (best[i.min(numbers - 1)] - 2.0 * spacing, best[i.min(numbers - 1)] + 2.0 * spacing);
            let (low, high) = (b.0.max(around.0), b.1.min(around.1));
            if i < numbers && low < high { (low, high) } else { *b }
        };
        let bounds = curves.bounds().iter().enumerate().map(narrow).collect();
        curves.set_bounds(bounds)?;
    }
    for copy in 0..COPIES.0 {
        let mut rng = crate::context::stream(seed, u64::from(u32::MAX), copy);
        let moved = best.iter().enumerate().map(|(i, v)| {
            let draw = rand::RngExt::random_range(&mut rng, -1.0..1.0);
            if i < numbers { v + COPIES.1 * spacing * draw } else { *v }
        });
        fits.push(moved.collect());
    }
    curves.set_hints(fits);
    Ok(())
}

/// Length (m) and quarter turns of each leg of a line.
pub(in crate::plan::swarm) fn legs(query: &Query, line: &[Point]) -> Vec<(f64, usize)> {
    let mut legs = Vec::new();
    let mut from = 0;
    for (i, stop) in query.stops().iter().enumerate().skip(1) {
        let last = i > query.via.len();
        let nearest = (from..line.len()).min_by(|&a, &b| distance(line[a], *stop).total_cmp(&distance(line[b], *stop)));
        let to = if last { line.len() - 1 } else { nearest.unwrap_or(from) };
        let part = &line[from..=to];
        let turning: f64 = part.windows(3).map(|w| turn(w[0], w[1], w[2])).sum();
        let length = part.windows(2).map(|w| distance(w[0], w[1])).sum();
        legs.push((length, (turning / FRAC_PI_2).ceil().min(1e4) as usize));
        from = to;
    }
    legs
}

fn turn(a: Point, b: Point, c: Point) -> f64 {
    let (u, v) = (sub(b, a), sub(c, b));
    cross(u, v).atan2(dot(u, v)).abs()
}
