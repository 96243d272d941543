//! The motions that cover the most for their duration.
//!
//! For a fixed duration all motions of an axis form a convex set, so the distances they cover form an interval. Its upper end is
//! covered by the motion with jerk `+ 0 - (0) - 0 +`: up, perhaps a cruise at the speed limit, down, and up again at the end. These
//! motions form one family with one parameter `sigma`: minus the lowest acceleration of the second half (without its limit). From
//! `sigma = -a_end`, the fastest change of speed, duration grows with `sigma`. The lower end is that of the mirror image.
//!
//! Where both accelerations have the same sign there may be a second, shorter component ([`Widest::brief`]): motions whose acceleration
//! never comes to zero. Its durations end where the last ramp vanishes.
//!
//! The distance as a function of the duration has the slope `H = v + a tau / 2` (the Hamiltonian; `tau` is the duration of the phase
//! of falling jerk that follows the first, `v` and `a` the speed and acceleration where it begins). `H` changes its sign at most
//! twice, at places known in closed form or by a monotone root, so every search below is in a stretch where the distance is monotone.

use super::leg::{Leg, Shape};
use super::line::Line;
use super::root;

/// The family of one axis, upper side of `line`.
#[derive(Debug, Clone, Copy)]
pub(super) struct Widest {
    /// Perhaps mirrored, perhaps reversed in time, so that its second resting speed is the higher one.
    line: Line,
    flipped: bool,
    reversed: bool,
    /// The higher resting speed.
    rest: f64,
    /// Squares of the peaks where the top speed is `rest`: first and second leg.
    squares: [f64; 2],
    /// Ends of `sigma`.
    range: (f64, f64),
    /// Acceleration never comes to zero: there is no cruise beyond the end.
    brief: bool,
}

/// A place of the family.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Place {
    sigma: f64,
    /// Cruise at the speed limit, s.
    cruise: f64,
    /// s.
    pub(super) time: f64,
}

/// What a member of the family covers.
#[derive(Debug, Clone, Copy)]
struct Cover {
    time: f64,
    distance: f64,
    /// Distance per duration in the family.
    slope: f64,
    /// Duration per `sigma`.
    pace: f64,
    /// Change of the slope per `sigma`.
    bend: f64,
}

/// Legs of a member, the second one in reversed time or, above zero trough, a ramp up.
enum Legs {
    /// Top speed with zero acceleration between the two.
    Peak(Leg, Leg),
    /// The acceleration does not come down to zero: the leg and the last ramp, s.
    Trough(Leg, f64),
}

impl Widest {
    /// The upper side of `line`, or of its mirror image.
    pub(super) fn new(line: &Line, flipped: bool) -> Self {
        let mut line = if flipped { line.flipped() } else { *line };
        let reversed = line.gap() < 0.0;
        if reversed {
            line = line.reversed();
        }
        let rest = line.rests()[1];
        let squares = [line.jerk * line.gap().max(0.0) + line.start.1.max(0.0).powi(2), (-line.end.1).max(0.0).powi(2)];
        let range = (-line.end.1.max(0.0), (line.jerk * (line.speed.1 - rest).max(0.0)).sqrt());
        Self { line, flipped, reversed, rest, squares, range, brief: false }
    }

    /// The upper side of the motions of `line`, or of its mirror image, whose acceleration keeps its sign; `None` where there are none,
    /// or where they are a part of [`Widest::new`].
    pub(super) fn brief(line: &Line, flipped: bool) -> Option<Self> {
        let mut line = if flipped { line.flipped() } else { *line };
        let reversed = line.start.1 < 0.0;
        if reversed {
            line = line.reversed();
        }
        let (a0, a1) = (line.start.1, line.end.1);
        // Square of the acceleration at which the last ramp has vanished.
        let last = -line.jerk * line.gap();
        let least = a0.min(a1) * a0.min(a1);
        let speed = line.start.0.abs().max(line.end.0.abs());
        let slack = 1e-12 * (line.jerk * speed + least);
        if !(a0 > 0.0 && a1 > 0.0 && last >= 0.0 && last <= least + slack) {
            return None;
        }
        let range = (-a1, -last.sqrt().min(a1));
        Some(Self { rest: line.rests()[1], squares: [a0 * a0 - last.min(least), 0.0], line, flipped, reversed, range, brief: true })
    }

    /// Sets a finite limit in place of an infinite one, beyond all that `distance` needs.
    pub(super) fn capped(mut self, distance: f64) -> (Self, f64) {
        let wanted = self.turned(distance);
        if self.range.1.is_infinite() {
            self.range.1 = (self.line.jerk * self.rest.abs()).sqrt().max(self.line.jerk).max(1e-150);
            while self.cover(self.range.1).distance < wanted && self.range.1 < 1e150 {
                self.range.1 *= 2.0;
            }
            self.line.speed.1 = self.rest + self.range.1 * self.range.1 / self.line.jerk;
        }
        let limit = self.line.speed.1;
        (self, limit)
    }

    #[inline]
    fn legs(&self, sigma: f64) -> Legs {
        let Line { start, end, up, down, jerk, inverse, .. } = self.line;
        let jerk = (jerk, inverse);
        let y = sigma * sigma;
        if sigma >= 0.0 {
            Legs::Peak(Leg::new(self.squares[0] + y, (start.1, 0.0), up, jerk), Leg::new(self.squares[1] + y, (-end.1, 0.0), down, jerk))
        } else {
            Legs::Trough(Leg::new(self.squares[0] + y, (start.1, -sigma), up, jerk), (end.1 + sigma).max(0.0) * inverse)
        }
    }

    /// What the member at `sigma` covers, without a cruise.
    #[inline]
    fn cover(&self, sigma: f64) -> Cover {
        let Line { jerk, inverse, .. } = self.line;
        match self.legs(sigma) {
            Legs::Peak(first, second) => {
                let top = self.rest + sigma * sigma * inverse;
                let time = first.time() + second.time();
                let part = |peak: f64| if peak > 0.0 { sigma / peak } else { 1.0 };
                let (p, q) = (part(first.peak), part(second.peak));
                let free = |leg: &Leg, x: f64| if leg.held() { 0.0 } else { x };
                Cover {
                    time,
                    distance: top * time - first.area - second.area,
                    slope: top + first.peak * second.peak * (0.5 * inverse),
                    pace: 2.0 * (p + q) * inverse,
                    bend: (2.0 * sigma + 0.5 * (free(&first, p) * second.peak + free(&second, q) * first.peak)) * inverse,
                }
            }
            Legs::Trough(leg, ramp) => {
                let trough = -sigma;
                let bottom = self.rest + trough * trough * (0.5 * inverse);
                let span = leg.time();
                Cover {
                    time: span + ramp,
                    distance: bottom * span - leg.area + ramp * (bottom + ramp * (0.5 * trough + jerk * ramp * (1.0 / 6.0))),
                    slope: self.slope_above(trough).0,
                    bend: f64::NAN,
                    pace: if leg.peak > 0.0 { 2.0 * (leg.peak - trough).max(0.0) / (leg.peak * jerk) } else { 0.0 },
                }
            }
        }
    }

    /// `H` where the lowest acceleration of the second half is `trough`, positive, and its derivative.
    #[inline]
    fn slope_above(&self, trough: f64) -> (f64, f64) {
        let free = (self.squares[0] + trough * trough).sqrt();
        let (peak, grows) = if free > self.line.up { (self.line.up, 0.0) } else { (free, trough / free) };
        let half = 0.5 * self.line.inverse;
        (self.rest + trough * (2.0 * trough - peak) * half, (4.0 * trough - peak - trough * grows) * half)
    }

    /// Distance of the fastest change of speed, seen from the unmirrored axis, and its duration.
    pub(super) fn least(&self) -> (f64, f64) {
        let cover = self.cover(self.range.0);
        (self.turned(cover.distance), cover.time)
    }

    /// The longest duration of the family, s; infinite unless it is brief.
    pub(super) fn longest(&self) -> f64 {
        if self.brief { self.cover(self.range.1).time } else { f64::INFINITY }
    }

    /// The fastest change of speed.
    pub(super) fn fastest(&self) -> Place {
        self.place(self.range.0)
    }

    #[inline]
    fn turned(&self, distance: f64) -> f64 {
        if self.flipped { -distance } else { distance }
    }

    /// The distance grows up to the first place, falls to the second and grows from there; the two are equal where it only grows.
    fn turns(&self) -> (f64, f64) {
        let (start, end) = self.range;
        if start >= 0.0 {
            return (start, if self.cover(start).slope < 0.0 { self.ground(end) } else { start });
        }
        let a1 = -start;
        let most = (self.squares[0] + a1 * a1).min(self.line.up * self.line.up);
        if self.rest >= most / (16.0 * self.line.jerk) {
            return (start, start);
        }
        let nearest = (-end).max(0.0);
        let lowest = self.flattest(a1).max(nearest);
        if self.slope_above(lowest).0 >= 0.0 {
            return (start, start);
        }
        let sloped = |sign: f64, range: (f64, f64)| {
            -root::rising(range, f64::NAN, |x| {
                let (slope, bend) = self.slope_above(x);
                (sign * slope, sign * bend, 0.0)
            })
        };
        let risen = if self.slope_above(a1).0 > 0.0 { sloped(1.0, (lowest, a1)) } else { start };
        let fallen = if self.slope_above(nearest).0 > 0.0 {
            sloped(-1.0, (nearest, lowest))
        } else if self.brief {
            end
        } else {
            self.ground(end)
        };
        (risen, fallen)
    }

    /// The trough in `[0, a1]` at which `H` is lowest.
    fn flattest(&self, a1: f64) -> f64 {
        let free = (self.squares[0] * ((192f64).sqrt() - 12.0) / 24.0).sqrt();
        let switch = (self.line.up * self.line.up - self.squares[0]).max(0.0).sqrt();
        (if free < switch { free } else { switch.max(0.25 * self.line.up) }).min(a1)
    }

    /// Where `H` becomes positive above `sigma = 0`.
    fn ground(&self, end: f64) -> f64 {
        root::rising((0.0, end), (-self.rest * self.line.jerk).max(0.0).sqrt(), |s| {
            let cover = self.cover(s);
            (cover.slope, cover.bend, 0.0)
        })
    }

    /// The first member that covers at least `distance` (of the unmirrored axis) but for `slack`.
    pub(super) fn first(&self, distance: f64, slack: f64) -> Option<Place> {
        let (start, (risen, fallen)) = (self.range.0, self.turns());
        let wanted = self.turned(distance);
        if risen > start && self.cover(risen).distance >= wanted - slack {
            return Some(self.place(self.solve((start, risen), 1.0, wanted)));
        }
        self.last_from(fallen, wanted, slack)
    }

    /// Durations between which the family falls short of `distance`, although it covers that before and after.
    pub(super) fn blocked(&self, distance: f64, slack: f64) -> Option<(f64, f64)> {
        let wanted = self.turned(distance);
        if self.range.0 >= 0.0 && self.cover(self.range.0).distance < wanted - slack {
            return None;
        }
        let (risen, fallen) = self.turns();
        if risen >= fallen {
            return None;
        }
        let before = self.cover(risen).distance >= wanted - slack;
        if !before || self.cover(fallen).distance >= wanted - slack {
            return None;
        }
        let from = self.cover(self.solve((risen, fallen), -1.0, wanted)).time;
        Some((from, self.last_from(fallen, wanted, slack).map_or(f64::INFINITY, |place| place.time)))
    }

    fn last_from(&self, fallen: f64, wanted: f64, slack: f64) -> Option<Place> {
        let end = self.range.1;
        let most = self.cover(end);
        if wanted < most.distance {
            let mut range = (fallen, end);
            if fallen < 0.0 && end > 0.0 {
                range = if self.cover(0.0).distance <= wanted { (0.0, end) } else { (fallen, 0.0) };
            }
            return Some(self.place(self.solve(range, 1.0, wanted)));
        }
        let beyond = wanted - most.distance;
        let top = self.line.speed.1;
        if self.brief || top <= 0.0 {
            return (beyond <= slack).then(|| self.place(end));
        }
        let cruise = beyond / top;
        Some(Place { sigma: end, cruise, time: most.time + cruise })
    }

    /// The member in a monotone stretch that covers `wanted`, or the end of the stretch nearest to it.
    fn solve(&self, (low, high): (f64, f64), sign: f64, wanted: f64) -> f64 {
        // Where all is free, the distance grows at least by this cube.
        let guess = if low == 0.0 && sign > 0.0 {
            let more = (wanted - self.cover(0.0).distance).max(0.0);
            (0.5 * more * self.line.jerk * self.line.jerk).cbrt()
        } else {
            f64::NAN
        };
        root::rising((low, high), guess, |sigma| {
            let cover = self.cover(sigma);
            (sign * (cover.distance - wanted), sign * cover.slope * cover.pace, 0.0)
        })
    }

    fn place(&self, sigma: f64) -> Place {
        Place { sigma, cruise: 0.0, time: self.cover(sigma).time }
    }

    /// The member of the duration `time`, at least that of the fastest change of speed; the distance it covers.
    pub(super) fn lasting(&self, time: f64) -> (Place, f64) {
        let end = self.cover(self.range.1);
        if self.brief && time >= end.time {
            return (self.place(self.range.1), self.turned(end.distance));
        }
        if time >= end.time {
            let cruise = time - end.time;
            return (Place { sigma: self.range.1, cruise, time }, self.turned(end.distance + cruise * self.line.speed.1));
        }
        let sigma = root::rising(self.range, f64::NAN, |s| {
            let cover = self.cover(s);
            (cover.time - time, cover.pace, 0.0)
        });
        (Place { sigma, cruise: 0.0, time }, self.turned(self.cover(sigma).distance))
    }

    /// The phases of a member.
    pub(super) fn shape(&self, place: &Place) -> Shape {
        let jerk = self.line.jerk;
        let mut shape = Shape::new();
        match self.legs(place.sigma) {
            Legs::Peak(first, second) => {
                first.phases(1.0, jerk).iter().for_each(|p| shape.push(p.duration, p.jerk));
                shape.push(place.cruise, 0.0);
                second.phases(1.0, jerk).iter().rev().for_each(|p| shape.push(p.duration, p.jerk));
            }
            Legs::Trough(leg, ramp) => {
                leg.phases(1.0, jerk).iter().for_each(|p| shape.push(p.duration, p.jerk));
                shape.push(ramp, jerk);
            }
        }
        let shape = if self.reversed { shape.reversed() } else { shape };
        if self.flipped { shape.flipped() } else { shape }
    }
}
