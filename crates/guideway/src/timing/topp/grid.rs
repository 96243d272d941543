//! Grids: spans of the path between nodes, refined where the motion changes.

use super::course::{Course, Span, Way};

/// Spans on which places of the path are found by their arc length.
pub(super) const WALK: usize = 400;

/// Spans shorter than this share of the path are not cut further, and those shorter than this along which the speed by the parameter changes less than by
/// this factor.
const LEAST: f64 = 1e-10;
const SHORT: f64 = 1e-4;
const EVEN: f64 = 0.8;
/// Error of the arc length within a span, as a share of its length.
const FIT: f64 = 1e-9;
/// Error of the arc length itself, as a share of the path.
const KNOWN: f64 = 1e-10;

/// The intervals of a grid, and the shape of the path at their ends and in their middles.
#[derive(Debug)]
pub(super) struct Grid {
    pub spans: Vec<Span>,
    /// Whether the motion must stop at the node before each interval (and after the last).
    pub stops: Vec<bool>,
}

impl Grid {
    /// About `count` intervals, a few at least between breaks of the path.
    pub fn initial(course: &Course, count: usize, turns: bool) -> Self {
        let mut spans = Vec::with_capacity(2 * count);
        let least = (count / course.count()).clamp(1, 4);
        for piece in 0..course.count() {
            let mut breaks = vec![0.0];
            breaks.extend(course.breaks(piece, turns));
            breaks.push(1.0);
            for w in breaks.windows(2) {
                let ends = [course.place(piece, w[0]), course.place(piece, w[1])];
                let share = (ends[1].s - ends[0].s) / course.length;
                let n = ((count as f64 * share).round() as usize).max(least).next_multiple_of(least.min(2));
                let mut from = ends[0];
                for i in 1..=n {
                    let to = if i == n { ends[1] } else { course.place(piece, w[0] + (w[1] - w[0]) * i as f64 / n as f64) };
                    if to.s > from.s {
                        resolve(course, Span { piece, t: [from.t, to.t], s: [from.s, to.s] }, &mut spans);
                        from = to;
                    }
                }
            }
        }
        Self::new(course, spans)
    }

    /// A grid of the given spans.
    pub fn new(course: &Course, spans: Vec<Span>) -> Self {
        let mut stops = vec![false; spans.len() + 1];
        for (k, w) in spans.windows(2).enumerate() {
            stops[k + 1] = course.jumps(&w[0], &w[1]);
        }
        Self { spans, stops }
    }

    /// `count` intervals of equal arc length, and the places where pieces meet or the path turns back besides.
    pub fn even(course: &Course, count: usize, turns: bool) -> Self {
        // Places are found on spans of their own, short enough for arc length within them to be exact.
        let breaks = Self::initial(course, WALK, turns);
        let mut at: Vec<f64> = (0..=count).map(|i| course.length * i as f64 / count as f64).collect();
        let tiny = 1e-3 * course.length / count as f64;
        let fixed = self::breaks(course, turns);
        let stops: Vec<f64> = breaks.spans.iter().zip(&breaks.stops).filter(|(_, stop)| **stop).map(|(s, _)| s.s[0]).collect();
        at.retain(|s| fixed.iter().chain(&stops).all(|f| (f - s).abs() > tiny || *f == *s));
        at.extend(fixed.into_iter().chain(stops));
        at.push(course.length);
        at.sort_by(f64::total_cmp);
        at.dedup();
        let spans = at.windows(2).filter_map(|w| breaks.between(course, [w[0], w[1]])).collect();
        Self::new(course, spans)
    }

    /// The span between two arc lengths on one piece.
    fn between(&self, course: &Course, s: [f64; 2]) -> Option<Span> {
        let middle = 0.5 * (s[0] + s[1]);
        let k = self.spans.partition_point(|span| span.s[0] <= middle).checked_sub(1)?;
        let piece = self.spans[k].piece;
        let t = s.map(|s| self.parameter(course, piece, s));
        (t[1] > t[0]).then_some(Span { piece, t, s })
    }

    /// Parameter on a piece at an arc length.
    fn parameter(&self, course: &Course, piece: usize, s: f64) -> f64 {
        let first = self.spans.partition_point(|span| span.piece < piece);
        let count = self.spans[first..].partition_point(|span| span.piece == piece);
        let spans = &self.spans[first..first + count];
        if s <= spans[0].s[0] {
            return spans[0].t[0];
        }
        if s >= spans[count - 1].s[1] {
            return spans[count - 1].t[1];
        }
        let k = spans.partition_point(|span| span.s[0] <= s) - 1;
        invert(course, &spans[k], s)
    }

    /// Arc lengths of the nodes.
    pub fn nodes(&self) -> Vec<f64> {
        let mut s: Vec<f64> = self.spans.iter().map(|span| span.s[0]).collect();
        s.extend(self.spans.last().map(|span| span.s[1]));
        s
    }

    /// The grid with every interval `k` split at the given arc lengths.
    pub fn split(&self, course: &Course, cuts: &[Vec<f64>]) -> Self {
        let mut spans = Vec::with_capacity(2 * self.spans.len());
        let mut stops = Vec::with_capacity(2 * self.spans.len());
        for (k, span) in self.spans.iter().enumerate() {
            let mut rest = *span;
            stops.push(self.stops[k]);
            for s in cuts.get(k).into_iter().flatten() {
                let t = invert(course, &rest, *s);
                let s = course.length_at(rest.piece, t);
                if t > rest.t[0] && t < rest.t[1] && s > rest.s[0] && s < rest.s[1] {
                    spans.push(Span { t: [rest.t[0], t], s: [rest.s[0], s], ..rest });
                    stops.push(false);
                    rest = Span { t: [t, rest.t[1]], s: [s, rest.s[1]], ..rest };
                }
            }
            spans.push(rest);
        }
        stops.push(self.stops.last().copied().unwrap_or(false));
        Self { spans, stops }
    }
}

/// Adds a span, cut into halves until a quintic gives the arc length within each: beside a place where the path all but stops by its parameter it would
/// not.
fn resolve(course: &Course, span: Span, spans: &mut Vec<Span>) {
    let middle = course.place(span.piece, 0.5 * (span.t[0] + span.t[1]));
    let tiny = span.length() < LEAST * course.length || middle.s <= span.s[0] || middle.s >= span.s[1];
    let fits = || {
        let [a, b] = span.t.map(|t| course.speed(span.piece, t));
        let even = a.min(b) > EVEN * a.max(b);
        let miss = (Way::of(course, &span).at(0.5) - (middle.s - span.s[0])).abs();
        miss < FIT * span.length() || (even && (span.length() < SHORT * course.length || miss < KNOWN * course.length))
    };
    if tiny || fits() {
        spans.push(span);
        return;
    }
    resolve(course, Span { t: [span.t[0], middle.t], s: [span.s[0], middle.s], ..span }, spans);
    resolve(course, Span { t: [middle.t, span.t[1]], s: [middle.s, span.s[1]], ..span }, spans);
}

/// Arc lengths where polynomial pieces meet, where the path slows down by its parameter and, if asked for, where a joint turns back; both ends too.
pub(super) fn breaks(course: &Course, turns: bool) -> Vec<f64> {
    let mut s = vec![0.0];
    for piece in 0..course.count() {
        s.extend(course.breaks(piece, turns).into_iter().map(|t| course.place(piece, t).s));
        s.push(course.place(piece, 1.0).s);
    }
    s.dedup_by(|b, a| *b <= *a);
    s
}

/// Parameter in a span at an arc length.
fn invert(course: &Course, span: &Span, s: f64) -> f64 {
    let way = Way::of(course, span);
    let (mut low, mut high, target) = (0.0, 1.0, s - span.s[0]);
    let mut tau = target / span.length();
    for _ in 0..50 {
        let miss = way.at(tau) - target;
        if miss.abs() <= 1e-13 * span.length() {
            break;
        }
        if miss > 0.0 {
            high = tau;
        } else {
            low = tau;
        }
        let slope = (way.at(tau + 1e-5) - way.at(tau - 1e-5)) / 2e-5;
        let next = tau - miss / slope;
        tau = if next > low && next < high { next } else { 0.5 * (low + high) };
    }
    span.t[0] + (span.t[1] - span.t[0]) * tau
}
