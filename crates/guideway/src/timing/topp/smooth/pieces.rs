//! Pieces of constant jerk through states on the path, and their check.

use crate::timing::Piece;
use crate::timing::scurve::advance;
use crate::timing::topp::course::{Course, Shape, Span, Way};

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

/// How far inside a stretch its ends are read, as a share of it.
const INSIDE: f64 = 1e-12;

/// Walks along the path by arc length.
pub(super) struct Walker<'a> {
    pub course: &'a Course,
    spans: &'a [Span],
    /// The way on every span, and its parameter by the way: the cubic through both ends.
    ways: Vec<(Way, [f64; 3])>,
    at: usize,
    /// Where the stretch that is walked begins and ends: directions may jump there, so it is read a little inside.
    range: [f64; 2],
    /// Where polynomial pieces meet: arc length, and piece and parameter on either side.
    pub joints: Vec<(f64, [(usize, f64); 2])>,
    pub shape: Shape,
}

/// Share of the mean speed by the parameter that counts as the least at the ends of spans.
const LEAST: f64 = 0.1;

/// Share of the mean speed by the parameter below which derivatives by the parameter lose digits.
const SLOW: f64 = 0.01;

impl<'a> Walker<'a> {
    /// Along the stretch of a path between two arc lengths.
    pub fn new(course: &'a Course, spans: &'a [Span], [from, to]: [f64; 2]) -> Self {
        let back = |way: &Way, length: f64| {
            let [a, b] = [0.0, 1.0].map(|tau| length / way.slope(tau).max(LEAST * length));
            [a, 3.0 - 2.0 * a - b, a + b - 2.0]
        };
        let both = |span: &Span| {
            let way = Way::of(course, span);
            (way, back(&way, span.length()))
        };
        let ways = spans.iter().map(both).collect();
        let aside = INSIDE * (to - from);
        let meet = spans.windows(2).filter(|w| w[0].piece != w[1].piece && w[0].s[1] > from);
        let joints = meet.map(|w| (w[0].s[1], [(w[0].piece, w[0].t[1]), (w[1].piece, w[1].t[0])])).collect();
        Self { course, spans, ways, at: 0, range: [from + aside, to - aside], joints, shape: Shape::new(course.dimension) }
    }

    /// Three derivatives by arc length at arc length `s`, which may not go back far.
    pub fn go(&mut self, s: f64) {
        let (piece, t) = self.find(s);
        self.course.full_shape(piece, t, &mut self.shape);
    }

    /// Three derivatives at arc length `s` and three factors: those of what is moved with a speed, an acceleration and a jerk, by arc length where the path
    /// all but stops by its parameter, else by the parameter.
    pub fn drive(&mut self, s: f64, moving: [f64; 3]) -> [f64; 3] {
        let (piece, t) = self.find(s);
        let factors = self.course.driven(piece, t, moving, &mut self.shape);
        let span = &self.spans[self.at];
        if self.shape.rate[0] > SLOW * span.length() / (span.t[1] - span.t[0]) {
            return factors;
        }
        self.course.full_shape(piece, t, &mut self.shape);
        moving
    }

    /// Piece and parameter at arc length `s`.
    fn find(&mut self, s: f64) -> (usize, f64) {
        let s = s.clamp(self.range[0], self.range[1]);
        while self.at + 1 < self.spans.len() && s >= self.spans[self.at].s[1] {
            self.at += 1;
        }
        while self.at > 0 && s < self.spans[self.at].s[0] {
            self.at -= 1;
        }
        let (span, (way, [a, b, c])) = (&self.spans[self.at], &self.ways[self.at]);
        let target = (s - span.s[0]).clamp(0.0, span.length());
        let share = target / span.length();
        let (mut tau, mut low, mut high) = ((share * (a + share * (b + share * c))).clamp(0.0, 1.0), 0.0, 1.0);
        for _ in 0..50 {
            let miss = way.at(tau) - target;
            if miss.abs() <= 1e-12 * span.length() {
                break;
            }
            if miss > 0.0 {
                high = tau;
            } else {
                low = tau;
            }
            // Where the curve comes to rest by its parameter a step may lead beyond the end.
            let next = tau - miss / way.slope(tau);
            tau = if next > low && next < high { next } else { 0.5 * (low + high) };
        }
        (span.piece, span.t[0] + (span.t[1] - span.t[0]) * tau)
    }
}
