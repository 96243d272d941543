//! Curves as candidates of an optimizer: from numbers to a spline, its objective, and back from a polyline to numbers.

use super::basis::Basis;
use super::clearance::Obstacles;
use super::samples::{NODES, STEP, Scratch};
use super::settings::{Form, References, Settings};
use super::speed::FirstPass;
use crate::Point;
use crate::error::PlanError;
use crate::optimize::{Cost, Objective};
use crate::path::Path;
use crate::query::{Limits, Query};
use crate::world::shape::distance;
use std::hint::black_box;
use std::time::Instant;

/// Range of the scales.
const SCALES: (f64, f64) = (0.3, 1.0);
/// Largest curvature, in the inverse of the larger of a cell and the distance to keep.
const SHARPEST: f64 = 30.0;
/// Repetitions of a part that is timed.
const SPLIT: u32 = 8;
/// Rate of the heading accelerations in the literal objective, Hz.
const RATE: f64 = 10.0;
/// What a curve is worth, term by term.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Judged {
    /// `L`, m.
    pub length: f64,
    /// `T` of the first pass, seven phases over the whole path, s.
    pub time: f64,
    /// Repaired: integral of the absolute heading acceleration over time, rad/s. Literal: its sum at 10 Hz, rad/s2.
    pub turning: f64,
    /// Least distance of the reference point from an obstacle, m; infinite without obstacles. Exact where the curve is free.
    pub clearance: f64,
    /// How much the first pass exceeds the speed ceiling: integral of `v / v_c - 1` over the path, as a share of its length.
    pub overspeed: f64,
    /// The objective `f`, half of the overspeed included.
    pub value: f64,
    /// Relative lack of clearance, at the worst place plus on average, plus the relative distance outside of the world, plus the relative excess of
    /// curvature over [`Curves::sharpest`]; 0 where the curve is free.
    pub violation: f64,
}

impl Judged {
    /// How candidates compare: free ones first, then by value.
    pub fn cost(&self) -> Cost {
        Cost { violation: self.violation, value: self.value, tie: 0.0 }
    }
}

/// The curves of one query.
///
/// A candidate is the free control points of a clamped cubic B-spline from start to goal, x and y by turns (m, map frame), then, if searched, the scales
/// `k_v, k_a, k_j`. With via points the spline passes through each of them, at a knot, with continuous curvature.
#[derive(Debug, Clone)]
pub struct Curves {
    query: Query,
    settings: Settings,
    references: References,
    basis: Basis,
    obstacles: Obstacles,
    bounds: Vec<(f64, f64)>,
    hints: Vec<Vec<f64>>,
}

impl Curves {
    /// Candidates that [`Curves::fit`] judges.
    pub const FITS: u64 = 4;

    /// Curves with `settings.points` free control points on each leg (five if that is 0).
    /// # Errors
    /// Those of [`Query::validate`]; [`PlanError::BadParameter`] for settings that make no sense.
    pub fn new(query: &Query, settings: &Settings) -> Result<Self, PlanError> {
        let points = if settings.points == 0 { 5 } else { settings.points };
        let legs: Vec<(usize, f64)> = query.stops().windows(2).map(|w| (points, distance(w[0], w[1]))).collect();
        Self::along(query, settings, &legs)
    }

    /// Curves with as many free control points and as long a share of the spline for each leg as told: (points, length in m).
    /// # Errors
    /// As [`Curves::new`].
    pub fn along(query: &Query, settings: &Settings, legs: &[(usize, f64)]) -> Result<Self, PlanError> {
        query.validate()?;
        settings.check()?;
        if legs.len() != query.via.len() + 1 {
            return Err(PlanError::bad("legs", legs.len(), format!("one for each of {} legs", query.via.len() + 1)));
        }
        let spans: Vec<usize> = legs.iter().map(|l| l.0.max(3) - 1).collect();
        let lengths: Vec<f64> = legs.iter().map(|l| l.1).collect();
        let basis = Basis::new(&spans, &lengths, &query.via);
        let [x0, y0, x1, y1] = query.world.bounds();
        let mut bounds = [(x0, x1), (y0, y1)].repeat(basis.free.len());
        if settings.scales {
            bounds.extend([SCALES; 3]);
        }
        let references = settings.scale(query);
        let obstacles = Obstacles::new(query);
        Ok(Self { query: query.clone(), settings: *settings, references, basis, obstacles, bounds, hints: Vec::new() })
    }

    /// Free control points.
    pub fn points(&self) -> usize {
        self.basis.free.len()
    }

    /// Encoding and objective.
    pub fn settings(&self) -> &Settings {
        &self.settings
    }

    /// Curvature above which a curve is no candidate, 1/m: a motion would have to creep around what is next to a cusp.
    pub fn sharpest(&self) -> f64 {
        SHARPEST / self.query.world.resolution().max(self.obstacles.needed)
    }

    /// What is asked.
    pub fn query(&self) -> &Query {
        &self.query
    }

    /// Candidates for the first population.
    pub fn set_hints(&mut self, hints: Vec<Vec<f64>>) {
        self.hints = hints;
    }

    /// Narrows or moves the box that candidates come from.
    /// # Errors
    /// [`PlanError::BadParameter`] for another number of pairs.
    pub fn set_bounds(&mut self, bounds: Vec<(f64, f64)>) -> Result<(), PlanError> {
        if bounds.len() != self.bounds.len() {
            return Err(PlanError::bad("bounds", bounds.len(), format!("{} pairs", self.bounds.len())));
        }
        self.bounds = bounds;
        Ok(())
    }

    /// Control points of a candidate, start and goal included, m.
    pub fn control(&self, x: &[f64]) -> Vec<Point> {
        let mut control = Vec::new();
        self.decode(x, &mut control);
        control
    }

    fn decode(&self, x: &[f64], control: &mut Vec<Point>) {
        let count = self.basis.count();
        control.resize(count, [0.0; 2]);
        (control[0], control[count - 1]) = (self.query.start, self.query.goal);
        for (i, p) in self.basis.free.iter().zip(x.chunks_exact(2)) {
            control[*i] = [p[0], p[1]];
        }
        self.basis.pin(control);
    }

    /// At most `most` (and at least one per piece) points along a candidate's curve, both ends among them, m.
    pub fn chain(&self, x: &[f64], most: usize) -> Vec<Point> {
        let control = self.control(x);
        let each = (most.saturating_sub(1) / self.basis.pieces()).clamp(1, 8);
        let mut out = vec![self.query.start];
        for k in 0..self.basis.pieces() {
            let c = self.basis.piece(k, &control);
            let at = |t: f64| [0, 1].map(|d| c[d][0] + t * (c[d][1] + t * (c[d][2] + t * c[d][3])));
            out.extend((1..=each).map(|i| at(i as f64 / each as f64)));
        }
        out
    }

    /// The path of a candidate.
    /// # Errors
    /// [`PlanError::BadParameter`] if its numbers are too few or not finite.
    pub fn path(&self, x: &[f64]) -> Result<Path, PlanError> {
        if x.len() != self.bounds.len() {
            return Err(PlanError::bad("candidate", format!("{} numbers", x.len()), format!("{} numbers", self.bounds.len())));
        }
        Path::new(3, 2, self.basis.knots.clone(), self.control(x).into_flattened())
    }

    /// The limits of the first pass of a candidate: those of the query, scaled.
    pub fn limits(&self, x: &[f64]) -> Limits {
        let limits = self.query.limits;
        match x.get(2 * self.basis.free.len()..) {
            Some(&[v, a, j]) => Limits {
                speed: v * limits.speed,
                acceleration: a * limits.acceleration,
                deceleration: a * limits.deceleration,
                jerk: j * limits.jerk,
                ..limits
            },
            _ => limits,
        }
    }

    /// Largest curvature of a candidate, 1/m; exact enough to tell whether it is above [`Curves::sharpest`].
    pub fn curvature(&self, x: &[f64]) -> f64 {
        let mut scratch = Scratch::default();
        self.decode(x, &mut scratch.control);
        scratch.sample(&self.basis);
        self.bend(&scratch)
    }

    fn bend(&self, scratch: &Scratch) -> f64 {
        let most = self.sharpest();
        scratch.pieces.iter().map(|piece| piece.sharpest(most)).fold(0.0, f64::max)
    }

    /// What a candidate is worth.
    pub fn judge(&self, x: &[f64]) -> Judged {
        self.worth(x, &mut Scratch::default())
    }

    fn worth(&self, x: &[f64], scratch: &mut Scratch) -> Judged {
        self.decode(x, &mut scratch.control);
        scratch.sample(&self.basis);
        let found = self.obstacles.judge(scratch);
        let (bend, most) = (self.bend(scratch), self.sharpest());
        let sharp = if bend > most { 1.0 - most / bend } else { 0.0 };
        let length = scratch.measure().max(1e-12);
        let pass = FirstPass::new(length, &self.limits(x));
        let (turning, excess) = self.motion(scratch, &pass);
        let turning = if self.settings.objective == Form::Literal { literal(scratch, &pass) } else { turning };
        let mut judged = Judged {
            length,
            time: pass.time,
            turning,
            clearance: found.clearance,
            overspeed: excess / length,
            value: 0.0,
            violation: found.violation + sharp,
        };
        judged.value = self.settings.value(&judged, self.references);
        judged
    }

    /// Total variation of the heading rate, rad/s, and the integral of the excess of speed, m.
    fn motion(&self, scratch: &Scratch, pass: &FirstPass) -> (f64, f64) {
        let per_turn = self.query.limits.turn_rate.map_or(0.0, f64::recip);
        let per_lateral = self.query.limits.lateral_acceleration.map_or(0.0, f64::recip);
        let (mut turning, mut excess, mut last) = (0.0, 0.0, 0.0);
        for (piece, place) in scratch.pieces.iter().zip(&scratch.places) {
            let (mut rate, mut over) = ([0.0; NODES], [0.0; NODES]);
            for j in 0..NODES {
                let v = pass.speed(place[j]);
                let bend = piece.curvature[j].abs();
                rate[j] = piece.curvature[j] * v;
                over[j] = (bend * v * per_turn).max(v * (bend * per_lateral).sqrt()) - 1.0;
            }
            turning += (rate[0] - last).abs();
            last = rate[NODES - 1];
            for j in 0..NODES - 1 {
                turning += (rate[j + 1] - rate[j]).abs();
                excess += 0.5 * (over[j].max(0.0) + over[j + 1].max(0.0)) * (place[j + 1] - place[j]);
            }
        }
        (turning + last.abs(), excess)
    }

    /// Seconds that the parts of the cost of these candidates take, one part after the other: curve, clearance, arc length, first pass with turning
    /// and overspeed. For benchmarks.
    pub fn split(&self, xs: &[Vec<f64>]) -> [f64; 4] {
        let mut scratch = Scratch::default();
        let mut times = [0.0; 4];
        for x in xs {
            self.decode(x, &mut scratch.control);
            scratch.sample(&self.basis);
            for (part, time) in times.iter_mut().enumerate() {
                // Each part many times: a look at the clock takes as long as one.
                let from = Instant::now();
                for _ in 0..SPLIT {
                    match part {
                        0 => {
                            self.decode(black_box(x), &mut scratch.control);
                            scratch.sample(&self.basis);
                        }
                        1 => drop(black_box(self.obstacles.judge(black_box(&mut scratch)))),
                        2 => drop(black_box(black_box(&mut scratch).measure())),
                        _ => {
                            let pass = FirstPass::new(scratch.places[scratch.places.len() - 1][NODES - 1], &self.limits(x));
                            black_box(self.motion(black_box(&scratch), &pass));
                        }
                    }
                }
                *time += from.elapsed().as_secs_f64() / f64::from(SPLIT);
            }
        }
        times
    }

    /// The candidate whose curve follows a polyline from start to goal (through the via points), as near as its control points allow: the best of those
    /// with control points on the line and those drawn towards passing through it.
    pub fn fit(&self, line: &[Point]) -> Vec<f64> {
        let targets = self.targets(line);
        let nodes = self.basis.greville();
        let mut control = targets.clone();
        let mut best: Option<(Cost, Vec<f64>)> = None;
        for _ in 0..Self::FITS {
            self.basis.pin(&mut control);
            let x = self.encode(&control);
            let cost = self.judge(&x).cost();
            if best.as_ref().is_none_or(|b| cost.beats(b.0)) {
                best = Some((cost, x));
            }
            let now: Vec<Point> = nodes.iter().map(|u| self.basis.at(&control, *u)).collect();
            for (c, (target, p)) in control.iter_mut().zip(targets.iter().zip(now)) {
                *c = [c[0] + target[0] - p[0], c[1] + target[1] - p[1]];
            }
        }
        best.map_or_else(Vec::new, |b| b.1)
    }

    fn encode(&self, control: &[Point]) -> Vec<f64> {
        let mut x: Vec<f64> = self.basis.free.iter().flat_map(|&i| control[i]).collect();
        x.resize(self.bounds.len(), SCALES.1);
        x.iter_mut().zip(&self.bounds).for_each(|(v, b)| *v = v.clamp(b.0, b.1));
        x
    }

    /// Where on the line each control point belongs.
    fn targets(&self, line: &[Point]) -> Vec<Point> {
        let mut s = vec![0.0];
        for w in line.windows(2) {
            s.push(s[s.len() - 1] + distance(w[0], w[1]));
        }
        let total = s[s.len() - 1];
        let stops = self.stops(line, &s);
        let at = |v: f64| {
            let k = s.partition_point(|x| *x <= v).clamp(1, line.len().max(2) - 1);
            let (Some(a), Some(b)) = (line.get(k - 1), line.get(k)) else { return self.query.start };
            let share = if s[k] > s[k - 1] { ((v - s[k - 1]) / (s[k] - s[k - 1])).clamp(0.0, 1.0) } else { 0.0 };
            [a[0] + share * (b[0] - a[0]), a[1] + share * (b[1] - a[1])]
        };
        let place = |u: f64| {
            let knots = &self.basis.stops;
            let leg = knots.partition_point(|k| *k <= u).clamp(1, knots.len() - 1) - 1;
            let share = (u - knots[leg]) / (knots[leg + 1] - knots[leg]);
            (stops[leg] + share * (stops[leg + 1] - stops[leg])).clamp(0.0, total)
        };
        self.basis.greville().into_iter().map(|u| at(place(u))).collect()
    }

    /// Arc lengths of the line's vertices nearest to start, via points and goal, in order.
    fn stops(&self, line: &[Point], s: &[f64]) -> Vec<f64> {
        let mut from = 0;
        let mut stops = vec![0.0];
        for p in &self.query.via {
            let nearest = (from..line.len()).min_by(|&i, &j| distance(line[i], *p).total_cmp(&distance(line[j], *p)));
            from = nearest.unwrap_or(from);
            stops.push(s[from]);
        }
        stops.push(s[s.len() - 1]);
        stops
    }
}

/// Sum of the absolute heading accelerations at 10 Hz, rad/s2, from differences of the heading rate.
fn literal(scratch: &Scratch, pass: &FirstPass) -> f64 {
    let count = (pass.time * RATE).ceil();
    let (mut piece, mut node, mut last, mut sum) = (0, 0, 0.0, 0.0);
    for i in 1..=count as u64 {
        let s = pass.place((i as f64 / RATE).min(pass.time));
        while scratch.places[piece][node + 1] < s && (piece + 1 < scratch.pieces.len() || node + 2 < NODES) {
            node += 1;
            if node + 1 == NODES {
                (piece, node) = (piece + 1, 0);
            }
        }
        let place = &scratch.places[piece];
        let width = place[node + 1] - place[node];
        let share = if width > 0.0 { ((s - place[node]) / width).clamp(0.0, 1.0) } else { 0.0 };
        let rate = scratch.pieces[piece].curvature_at(STEP * (node as f64 + share)) * pass.speed(s);
        sum += (rate - last).abs() * RATE;
        last = rate;
    }
    sum
}

impl Objective for Curves {
    fn bounds(&self) -> &[(f64, f64)] {
        &self.bounds
    }

    fn costs(&self, xs: &[Vec<f64>]) -> Result<Vec<Cost>, PlanError> {
        let mut scratch = Scratch::default();
        Ok(xs.iter().map(|x| self.worth(x, &mut scratch).cost()).collect())
    }

    fn hints(&self) -> &[Vec<f64>] {
        &self.hints
    }

    /// Some 4 us a piece.
    fn effort(&self) -> f64 {
        4.0 * self.basis.pieces() as f64
    }
}
