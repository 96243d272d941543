//! A leg: acceleration rises from one value to a peak, may be held at its limit, and falls to another value, all at the jerk limit.
//!
//! With `p` the peak, `f` the first and `l` the last acceleration, the speed grows by `(2 p^2 - f^2 - l^2) / (2 j) + p h`, where the
//! hold `h` is zero below the limit. All in terms of `q = p^2 + j p h`, the square of the peak without a limit, which is linear in
//! the speed gained.

use crate::timing::scurve::Phase;
use std::cmp::Ordering;

/// Durations of the three phases, and what they cover.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub(super) struct Leg {
    /// Ramp up, s.
    rise: f64,
    /// At the limit, s.
    hold: f64,
    /// Ramp down, s.
    fall: f64,
    /// Largest acceleration.
    pub(super) peak: f64,
    /// Integral over the leg of its last speed minus the speed.
    pub(super) area: f64,
}

impl Leg {
    /// From acceleration `first` to `last` with the square `q` of the peak, at most `limit`; jerk and one over it.
    #[inline]
    pub(super) fn new(q: f64, (first, last): (f64, f64), limit: f64, (jerk, inverse): (f64, f64)) -> Self {
        let free = q.max(0.0).sqrt();
        let (peak, hold) = if free > limit { (limit, (q - limit * limit) * inverse / limit) } else { (free, 0.0) };
        let rise = ((peak - first) * inverse).max(0.0);
        let fall = ((peak - last) * inverse).max(0.0);
        let short = fall * (last + 0.5 * jerk * fall);
        let late = short + peak * hold;
        let area = fall * fall * (0.5 * last + jerk * fall * (1.0 / 6.0))
            + hold * (short + 0.5 * peak * hold)
            + rise * (late + rise * (0.5 * peak - jerk * rise * (1.0 / 6.0)));
        Self { rise, hold, fall, peak, area }
    }

    /// Whether the limit is reached.
    #[inline]
    pub(super) fn held(&self) -> bool {
        self.hold > 0.0
    }

    /// Second derivative of the area by the speed gained.
    #[inline]
    pub(super) fn bend(&self) -> f64 {
        if self.peak > 0.0 { if self.held() { 1.0 / self.peak } else { 0.75 / self.peak } } else { 0.0 }
    }

    /// s.
    #[inline]
    pub(super) fn time(&self) -> f64 {
        self.rise + self.hold + self.fall
    }

    /// Its phases in the order of time, for accelerations of this sign.
    #[inline]
    pub(super) fn phases(&self, sign: f64, jerk: f64) -> [Phase; 3] {
        [
            Phase { duration: self.rise, jerk: sign * jerk },
            Phase { duration: self.hold, jerk: 0.0 },
            Phase { duration: self.fall, jerk: -sign * jerk },
        ]
    }
}

/// Phases of one axis, empty ones left out.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Shape {
    phases: [Phase; 8],
    count: usize,
}

impl Shape {
    #[inline]
    pub(super) fn new() -> Self {
        Self { phases: [Phase::default(); 8], count: 0 }
    }

    /// Appends a phase; one with the jerk of its predecessor prolongs that.
    #[inline]
    pub(super) fn push(&mut self, duration: f64, jerk: f64) {
        if duration <= 0.0 {
            return;
        }
        if self.count > 0 && self.phases[self.count - 1].jerk == jerk {
            self.phases[self.count - 1].duration += duration;
        } else if self.count < self.phases.len() {
            self.phases[self.count] = Phase { duration, jerk };
            self.count += 1;
        }
    }

    #[inline]
    pub(super) fn phases(&self) -> &[Phase] {
        &self.phases[..self.count]
    }

    /// The same motion seen in reversed time and with turned positions: speeds stay, the order is reversed.
    pub(super) fn reversed(mut self) -> Self {
        self.phases[..self.count].reverse();
        self
    }

    /// The mirror image.
    pub(super) fn flipped(mut self) -> Self {
        for phase in &mut self.phases[..self.count] {
            phase.jerk = -phase.jerk;
        }
        self
    }
}

/// A change of jerk: seconds after the start and before the end, and of which motion.
struct Event {
    after: f64,
    before: f64,
    second: bool,
}

impl Event {
    /// The changes of jerk of a motion, its end among them.
    fn all(phases: &[Phase], second: bool) -> impl Iterator<Item = Event> {
        let whole: f64 = phases.iter().map(|p| p.duration).sum();
        let mut after = 0.0;
        let sums: Vec<f64> = phases
            .iter()
            .map(|p| {
                after += p.duration;
                after
            })
            .collect();
        let mut before = 0.0;
        let mut events = Vec::with_capacity(phases.len());
        for (phase, after) in phases.iter().zip(sums).rev() {
            events.push(Event { after: after.min(whole), before, second });
            before += phase.duration;
        }
        events.into_iter().rev()
    }

    /// In the first half times are counted from the start, then from the end: a long cruise does not blur the short phases at either.
    fn early(&self) -> bool {
        self.after < self.before
    }

    fn order(&self, other: &Self) -> Ordering {
        match (self.early(), other.early()) {
            (true, true) => self.after.total_cmp(&other.after),
            (false, false) => other.before.total_cmp(&self.before),
            (early, _) => {
                if early {
                    Ordering::Less
                } else {
                    Ordering::Greater
                }
            }
        }
    }

    /// Seconds to a later one.
    fn until(&self, later: &Self) -> f64 {
        match (self.early(), later.early()) {
            (true, true) => later.after - self.after,
            (true, false) => (self.after + self.before) - self.after - later.before,
            _ => self.before - later.before,
        }
    }
}

/// Two motions of the same duration and the same ends, mixed: `share` of the second. Whatever convex limits both keep, the mixture
/// keeps as well.
pub(super) fn blend(first: &[Phase], second: &[Phase], share: f64) -> Vec<Phase> {
    let mut events: Vec<Event> = Event::all(first, false).chain(Event::all(second, true)).collect();
    events.sort_by(Event::order);
    let whole = events.last().map_or(0.0, |last| last.after);
    let mut now = Event { after: 0.0, before: whole, second: false };
    let (mut i, mut k) = (0, 0);
    let mut mixed: Vec<Phase> = Vec::with_capacity(events.len());
    for event in events {
        let (Some(one), Some(two)) = (first.get(i), second.get(k)) else { break };
        let duration = now.until(&event);
        if duration > 0.0 {
            mixed.push(Phase { duration, jerk: one.jerk + share * (two.jerk - one.jerk) });
        }
        if event.second {
            k += 1;
        } else {
            i += 1;
        }
        now = event;
    }
    mixed
}
