//! Pieces of constant jerk through states on the path, and their check.

use crate::error::PlanError;
use crate::timing::Piece;
use crate::timing::scurve::advance;
use crate::timing::topp::course::{Course, Shape, Span, Way};
use crate::timing::topp::limits::Bounds;
use crate::timing::topp::problem::{Demands, checked_ceiling, scale};

/// Arc length, speed, acceleration.
pub(super) type Moving = [f64; 3];

/// Two pieces of equal duration from one state to another: duration of each, jerks. Distance, speeds and accelerations leave one choice.
pub(super) fn connect(from: Moving, to: Moving) -> Option<(f64, [f64; 2])> {
    let (way, sum, change) = (to[0] - from[0], from[1] + to[1], to[2] - from[2]);
    let root = (sum * sum - 4.0 * change * way / 3.0).sqrt();
    let half = 2.0 * way / (sum + root);
    let first = (to[1] - from[1]) / half - 2.0 * from[2] - 0.5 * change;
    let jerks = [first / half, (change - first) / half];
    (half > 0.0 && half.is_finite() && jerks.iter().all(|j| j.is_finite())).then_some((half, jerks))
}

/// The pieces through states.
pub(super) fn through(states: &[Moving]) -> Option<Vec<Piece>> {
    let (mut pieces, mut t) = (Vec::with_capacity(2 * states.len()), 0.0);
    for w in states.windows(2) {
        let (duration, jerks) = connect(w[0], w[1])?;
        let mut state = (w[0][0], w[0][1], w[0][2]);
        for jerk in jerks {
            pieces.push(Piece::Along { t, s: state.0, speed: state.1, acceleration: state.2, jerk, duration });
            state = advance(state, jerk, duration);
            t += duration;
        }
    }
    Some(pieces)
}

/// Everything in slower time: by the factor `slower` >= 1.
pub(super) fn slowed(pieces: &mut [Piece], slower: f64) {
    for piece in pieces {
        if let Piece::Along { t, speed, acceleration, jerk, duration, .. } = piece {
            *t *= slower;
            *duration *= slower;
            *speed /= slower;
            *acceleration /= slower * slower;
            *jerk /= slower * slower * slower;
        }
    }
}

/// Walks along the path by arc length.
pub(super) struct Walker<'a> {
    course: &'a Course,
    spans: &'a [Span],
    ways: Vec<Way>,
    at: usize,
    pub shape: Shape,
}

impl<'a> Walker<'a> {
    pub fn new(course: &'a Course, spans: &'a [Span]) -> Self {
        let mut shape = Shape::new(course.dimension);
        let ways = spans.iter().map(|span| {
            let rates = [0.0, 1.0].map(|tau| {
                course.shape_in(span, tau, &mut shape);
                shape.rate
            });
            Way::new(span, rates)
        });
        let ways = ways.collect();
        Self { course, spans, ways, at: 0, shape }
    }

    /// Where polynomial pieces meet: arc length, and piece and parameter on either side.
    fn joints(&self) -> Vec<(f64, [(usize, f64); 2])> {
        let meet = self.spans.windows(2).filter(|w| w[0].piece != w[1].piece);
        meet.map(|w| (w[0].s[1], [(w[0].piece, w[0].t[1]), (w[1].piece, w[1].t[0])])).collect()
    }

    /// Three derivatives at arc length `s`, which may not go back far.
    pub fn go(&mut self, s: f64) {
        while self.at + 1 < self.spans.len() && s >= self.spans[self.at].s[1] {
            self.at += 1;
        }
        while self.at > 0 && s < self.spans[self.at].s[0] {
            self.at -= 1;
        }
        let (span, way) = (&self.spans[self.at], &self.ways[self.at]);
        let target = (s - span.s[0]).clamp(0.0, span.length());
        let mut tau = target / span.length();
        for _ in 0..4 {
            let miss = way.at(tau) - target;
            if miss.abs() <= 1e-12 * span.length() {
                break;
            }
            tau = (tau - miss / way.slope(tau)).clamp(0.0, 1.0);
        }
        self.course.full_shape(span.piece, span.t[0] + (span.t[1] - span.t[0]) * tau, &mut self.shape);
    }
}

/// Use of the limits of speed, acceleration and jerk (1 is the bound) on every pair of pieces, at `count` places of each piece.
pub(super) fn check(walker: &mut Walker, pieces: &[Piece], bounds: &Bounds, count: usize) -> Vec<[f64; 3]> {
    let mut used = vec![[0.0f64; 3]; pieces.len() / 2];
    walker.at = 0;
    let joints = walker.joints();
    let from = pieces.first().map_or(0.0, |piece| if let Piece::Along { s, .. } = piece { *s } else { 0.0 });
    let mut joints = &joints[joints.partition_point(|joint| joint.0 <= from)..];
    for (k, piece) in pieces.iter().enumerate() {
        let Piece::Along { s, speed, acceleration, jerk, duration, .. } = *piece else { continue };
        let start = (s, speed, acceleration);
        let mut past = [[0.0; 3]; 2];
        for j in 0..=count {
            let (s, v, a) = advance(start, jerk, duration * j as f64 / count as f64);
            walker.go(s);
            let now = gauge(&walker.shape, bounds, [v, a, jerk]);
            for i in 0..3 {
                let bulge = if j >= 2 { (2.0 * past[1][i] - past[0][i] - now[i]).max(0.0) / 8.0 } else { 0.0 };
                used[k / 2][i] = used[k / 2][i].max(now[i].max(past[1][i]) + bulge);
            }
            past = [past[1], now];
        }
        // Where polynomial pieces meet, the third derivative jumps: both sides count.
        let end = advance(start, jerk, duration).0;
        while joints.first().is_some_and(|joint| joint.0 <= end) {
            let (at, sides) = joints[0];
            joints = &joints[1..];
            let (_, v, a) = advance(start, jerk, reached(start, jerk, duration, at));
            for (piece, t) in sides {
                walker.course.full_shape(piece, t, &mut walker.shape);
                let now = gauge(&walker.shape, bounds, [v, a, jerk]);
                used[k / 2] = [0, 1, 2].map(|i| used[k / 2][i].max(now[i]));
            }
        }
    }
    used
}

/// Use of the limits of speed, acceleration and jerk where the path moves with a speed, an acceleration and a jerk.
fn gauge(shape: &Shape, bounds: &Bounds, [v, a, jerk]: [f64; 3]) -> [f64; 3] {
    let mut now = [0.0f64; 3];
    for i in 0..shape.first.len() {
        let (one, two, three) = (shape.first[i], shape.second[i], shape.third[i]);
        let rate = one * v;
        let second = one * a + two * v * v;
        let bound = if rate * second >= 0.0 { bounds.acceleration[i] } else { bounds.deceleration[i] };
        let third = one * jerk + v * (3.0 * two * a + three * v * v);
        now = [now[0].max(rate.abs() / bounds.speed[i]), now[1].max(second.abs() / bound), now[2].max(third.abs() / bounds.jerk[i])];
    }
    now
}

/// When a piece reaches an arc length.
fn reached(start: (f64, f64, f64), jerk: f64, duration: f64, s: f64) -> f64 {
    let (mut low, mut high) = (0.0, duration);
    for _ in 0..50 {
        let middle = 0.5 * (low + high);
        if advance(start, jerk, middle).0 < s {
            low = middle;
        } else {
            high = middle;
        }
    }
    0.5 * (low + high)
}

/// Adds the use of what is called for, at `count` places inside each piece.
pub(super) fn demands(demands: &mut Demands, pieces: &[Piece], count: usize, used: &mut [[f64; 4]]) -> Result<(), PlanError> {
    if demands.rows.is_none() && demands.ceiling.is_none() {
        return Ok(());
    }
    let mut places = Vec::with_capacity(pieces.len() * count);
    for piece in pieces {
        if let Piece::Along { s, speed, acceleration, jerk, duration, .. } = *piece {
            places.extend((0..count).map(|j| advance((s, speed, acceleration), jerk, duration * (j as f64 + 0.5) / count as f64)));
        }
    }
    let s: Vec<f64> = places.iter().map(|place| place.0).collect();
    if let Some(rows) = &mut demands.rows {
        let rows = rows(&s)?.checked(s.len())?;
        for (p, (_, v, a)) in places.iter().enumerate() {
            for i in p * rows.count..(p + 1) * rows.count {
                let value = rows.a[i] * a + rows.b[i] * v * v + rows.c[i] + rows.d.get(i).map_or(0.0, |d| d * v);
                let excess = (value - rows.high[i]).max(rows.low[i] - value) / scale([rows.low[i], rows.high[i]]);
                let used = &mut used[p / count / 2][3];
                *used = used.max(1.0 + excess);
            }
        }
    }
    if let Some(ceiling) = &mut demands.ceiling {
        let top = checked_ceiling(ceiling(&s)?, s.len())?;
        for (p, ((_, v, _), top)) in places.iter().zip(top).enumerate() {
            let used = &mut used[p / count / 2][0];
            *used = used.max(if *v > 0.0 { v / top.sqrt() } else { 0.0 });
        }
    }
    Ok(())
}
