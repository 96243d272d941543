//! Movers near the robot, laid out so that a look at all of them is quick.

use super::Track;
use crate::Point;

/// Movers that are looked at together.
const LANES: usize = 2;
/// Room to movers above which they no longer count as near, m.
pub(super) const WIDE: f64 = 0.8;
/// Shortcuts leave so much more room than what they stand for, m: rounding is far below.
const SURE: f64 = 1e-6;

/// A mover near enough to matter, with the distance that counts as contact in predictions.
#[derive(Clone, Copy)]
pub(super) struct Near<'a> {
    pub track: &'a Track,
    /// Of the disc around its reference point that covers it, m.
    pub radius: f64,
    pub speed: f64,
    pub keep: f64,
    pub growth: f64,
    /// How much its nearness matters, 0 for what cannot move to 1.
    pub lively: f64,
}

impl Near<'_> {
    /// Distance of the outline, `t` s from now at constant velocity, to a point, m.
    #[inline]
    pub fn distance(&self, p: Point, t: f64) -> f64 {
        let q = self.track;
        if self.round() {
            let (dx, dy) = (p[0] - q.position[0] - q.velocity[0] * t, p[1] - q.position[1] - q.velocity[1] * t);
            return (dx * dx + dy * dy).sqrt() - self.radius;
        }
        q.distance(p, t)
    }

    fn round(&self) -> bool {
        self.track.outline.points.len() == 1
    }
}

/// What movers mean for one place and time.
#[derive(Debug, Clone, Copy)]
pub(super) struct Around {
    /// Smallest room, m.
    pub room: f64,
    /// Time for which none can be met, s.
    pub safe: f64,
    /// Nearness, 0 to 1.
    pub close: f64,
}

/// Some movers, number by number; lanes that are not used are infinitely far away.
#[derive(Clone, Copy)]
struct Lane {
    x: [f64; LANES],
    y: [f64; LANES],
    /// Velocities, m/s, and one over their squares (0 for none).
    u: [f64; LANES],
    v: [f64; LANES],
    inverse: [f64; LANES],
    radius: [f64; LANES],
    speed: [f64; LANES],
    keep: [f64; LANES],
    growth: [f64; LANES],
    lively: [f64; LANES],
    /// Radius and distance kept, m; speed and growth, m/s.
    held: [f64; LANES],
    pace: [f64; LANES],
    /// What it may be off now, m, and its largest speed, m/s.
    doubt: [f64; LANES],
    bound: [f64; LANES],
    /// Are there others than discs?
    edged: bool,
    /// At most the room at first, m, of these and of all in later lanes.
    room: f64,
}

impl Lane {
    fn of(near: &[Near], room: f64) -> Self {
        let all = |value: fn(&Near) -> f64| std::array::from_fn(|k| near.get(k).map_or(0.0, value));
        Self {
            x: std::array::from_fn(|k| near.get(k).map_or(1e200, |n| n.track.position[0])),
            y: all(|n| n.track.position[1]),
            u: all(|n| n.track.velocity[0]),
            v: all(|n| n.track.velocity[1]),
            inverse: all(|n| if n.speed * n.speed > 0.0 { 1.0 / (n.speed * n.speed) } else { 0.0 }),
            radius: all(|n| n.radius),
            speed: all(|n| n.speed),
            keep: all(|n| n.keep),
            growth: all(|n| n.growth),
            lively: all(|n| n.lively),
            held: all(|n| n.radius + n.keep),
            pace: all(|n| n.speed + n.growth),
            doubt: all(|n| n.track.doubt),
            bound: all(|n| n.track.bound),
            edged: near.iter().any(|n| !n.round()),
            room,
        }
    }

    /// Squares of the distances of a point from where they are after `t` s at constant velocity, m2.
    #[expect(clippy::inline_always, reason = "the innermost loop of all predictions: lanes stay in registers")]
    #[inline(always)]
    fn squares(&self, p: Point, t: f64) -> [f64; LANES] {
        std::array::from_fn(|k| {
            let (dx, dy) = (p[0] - self.x[k] - self.u[k] * t, p[1] - self.y[k] - self.v[k] * t);
            dx * dx + dy * dy
        })
    }

    /// The room that such squares leave a disc of radius `r`, m.
    #[expect(clippy::inline_always, reason = "as above")]
    #[inline(always)]
    fn gaps(&self, squares: [f64; LANES], r: f64, t: f64) -> [f64; LANES] {
        std::array::from_fn(|k| squares[k].sqrt() - self.radius[k] - r - self.keep[k] - self.growth[k] * t)
    }
}

/// All movers that may matter in one control step, or those that may matter for a part of it, the nearest first.
pub(super) struct Crowd<'a> {
    near: Vec<Near<'a>>,
    lanes: Vec<Lane>,
    edged: bool,
    /// The largest speed that any may have, and at which any comes nearer in predictions, margins included, m/s.
    pub fastest: f64,
    haste: f64,
    /// To work out a part: rooms by lanes, and the rooms and the places of those that count, m.
    rooms: Vec<[f64; LANES]>,
    order: Vec<(f64, usize)>,
}

impl<'a> Crowd<'a> {
    pub fn new(near: Vec<Near<'a>>) -> Self {
        let fastest = near.iter().map(|n| n.track.bound).fold(0.0, f64::max);
        let lanes: Vec<Lane> = near.chunks(LANES).map(|near| Lane::of(near, f64::NEG_INFINITY)).collect();
        let edged = lanes.iter().any(|l| l.edged);
        Self { near, lanes, edged, fastest, haste: 0.0, rooms: Vec::new(), order: Vec::new() }
    }

    /// Puts into `part` those that may make a difference to [`Crowd::around`] (for `v` m/s) and [`Crowd::nearest`] between two times (s) for a robot that is covered by
    /// `discs` at first and whose points move at most at `moves` m/s: all others are farther than near, and farther and met later than another one.
    pub fn part(&self, discs: &(impl Iterator<Item = (Point, f64)> + Clone), [from, to]: [f64; 2], [v, moves]: [f64; 2], part: &mut Self) {
        part.rooms.clear();
        part.rooms.extend((0..self.lanes.len()).map(|i| {
            let of = discs.clone().map(|disc| self.gaps(i, disc, from));
            of.fold([f64::INFINITY; LANES], |room, gaps| std::array::from_fn(|k| least(gaps[k], room[k])))
        }));
        // Room and time until a contact, at most (1) or at least (-1).
        let bounds = |l: &Lane, room: &[f64; LANES], sign: f64| -> [[f64; 2]; LANES] {
            std::array::from_fn(|k| {
                let bound = room[k] + sign * ((moves + l.pace[k]) * (to - from) + SURE);
                [bound, bound / most(v + l.pace[k], 1e-6)]
            })
        };
        let mut limit = [f64::INFINITY; 2];
        for [room, time] in self.lanes.iter().zip(&part.rooms).flat_map(|(l, room)| bounds(l, room, 1.0)) {
            limit = [least(room, limit[0]), least(time, limit[1])];
        }
        limit[0] = most(limit[0], WIDE);
        part.order.clear();
        for (i, (l, rooms)) in self.lanes.iter().zip(&part.rooms).enumerate() {
            for (k, [room, time]) in bounds(l, rooms, -1.0).into_iter().enumerate() {
                if !(room > limit[0] && time > limit[1]) && LANES * i + k < self.near.len() {
                    part.order.push((rooms[k], LANES * i + k));
                }
            }
        }
        part.settle(self);
    }

    /// Puts into `part` those that may make a difference to [`Crowd::surely_beyond`] and [`Crowd::beyond`] between two times (s), for up to `more` s of any motion and discs
    /// within `r` m of a place that is at `p` at first and moves at most at `moves` m/s.
    pub fn threats(&self, (p, r): (Point, f64), [from, to]: [f64; 2], [moves, more]: [f64; 2], part: &mut Self) {
        part.order.clear();
        for (i, n) in self.near.iter().enumerate() {
            let (q, v) = (n.track.position, n.track.velocity);
            let (dx, dy) = (p[0] - q[0] - v[0] * from, p[1] - q[1] - v[1] * from);
            let room = (dx * dx + dy * dy).sqrt() - n.radius - n.track.doubt - n.track.bound * more - r;
            let away = room > (moves + n.speed) * (to - from) + 2.0 * SURE;
            if !away {
                part.order.push((room, i));
            }
        }
        part.settle(self);
    }

    /// Lays out those of `all` that are in order, the nearest first: most others then need no look.
    fn settle(&mut self, all: &Self) {
        self.order.sort_unstable_by(|a, b| a.0.total_cmp(&b.0));
        self.near.clear();
        self.near.extend(self.order.iter().map(|(_, i)| all.near[*i]));
        self.lanes.clear();
        self.lanes.extend(self.near.chunks(LANES).zip(self.order.iter().step_by(LANES)).map(|(near, (room, _))| Lane::of(near, *room)));
        self.edged = self.lanes.iter().any(|l| l.edged);
        self.fastest = all.fastest;
        self.haste = self.near.iter().map(|n| n.speed + n.growth).fold(0.0, f64::max);
    }

    /// By how much room may have become less at most, `t` s after a part was worked out and with the robot's points moved by `driven` m since then, m.
    pub fn spent(&self, driven: f64, t: f64) -> f64 {
        driven + self.haste * t + SURE
    }

    pub fn near(&self) -> &[Near<'a>] {
        &self.near
    }

    /// Room of the disc of radius `r` around `p` to the movers of a lane, at constant velocity after `t` s, m.
    #[expect(clippy::inline_always, reason = "as above")]
    #[inline(always)]
    fn gaps(&self, i: usize, (p, r): (Point, f64), t: f64) -> [f64; LANES] {
        let lane = &self.lanes[i];
        let mut gaps = lane.gaps(lane.squares(p, t), r, t);
        if self.lanes[i].edged {
            self.edge(i, (p, r), t, &mut gaps);
        }
        gaps
    }

    /// Puts in the room to those that are no discs.
    fn edge(&self, i: usize, (p, r): (Point, f64), t: f64, gaps: &mut [f64; LANES]) {
        for (gap, near) in gaps.iter_mut().zip(&self.near[LANES * i..]).filter(|(_, n)| !n.round()) {
            *gap = near.distance(p, t) - r - near.keep - near.growth * t;
        }
    }

    /// What they mean for a robot covered by `discs` whose points move at most at `v` m/s, after `t` s at constant velocity. In a part rooms have become less by at
    /// most `spent` m.
    #[inline]
    pub fn around(&self, discs: impl Iterator<Item = (Point, f64)>, (t, spent): (f64, f64), v: f64) -> Around {
        if self.edged { self.look::<true>(discs, (t, spent), v) } else { self.look::<false>(discs, (t, spent), v) }
    }

    #[inline]
    fn look<const EDGED: bool>(&self, discs: impl Iterator<Item = (Point, f64)>, (t, spent): (f64, f64), v: f64) -> Around {
        let (mut room, mut safe, mut close) = (f64::INFINITY, f64::INFINITY, 0.0);
        for (p, r) in discs {
            for (i, l) in self.lanes.iter().enumerate() {
                // Who is not near, and farther and met later than another one, makes no difference; nor does any after it.
                if l.room - spent > most(most(room, WIDE), safe * (v + self.haste)) {
                    break;
                }
                let mut gaps = l.gaps(l.squares(p, t), r, t);
                if EDGED {
                    self.edge(i, (p, r), t, &mut gaps);
                }
                for (k, gap) in gaps.into_iter().enumerate() {
                    room = least(gap, room);
                    safe = least(gap / most(v + l.speed[k] + l.growth[k], 1e-6), safe);
                }
                if gaps.iter().any(|gap| *gap < WIDE) {
                    for (gap, lively) in gaps.into_iter().zip(l.lively) {
                        close = most(lively * (1.0 - gap / WIDE), close);
                    }
                }
            }
        }
        Around { room, safe, close }
    }

    /// The number of the mover that leaves a robot covered by `discs` the least room.
    pub fn nearest(&self, discs: impl Iterator<Item = (Point, f64)>, t: f64) -> usize {
        let mut all = (f64::INFINITY, usize::MAX);
        for disc in discs {
            for i in 0..self.lanes.len() {
                for (gap, near) in self.gaps(i, disc, t).into_iter().zip(&self.near[LANES * i..]) {
                    if gap < all.0 {
                        all = (gap, near.track.id);
                    }
                }
            }
        }
        all.1
    }

    /// Visits those that may come to a robot that stays where it is, covered by `discs`, between these times (s) at constant velocity, each with the disc.
    #[inline]
    pub fn comers(&self, discs: impl Iterator<Item = (Point, f64)>, [from, to]: [f64; 2], mut visit: impl FnMut(&Near, (Point, f64))) {
        for (p, r) in discs {
            for (i, l) in self.lanes.iter().enumerate() {
                let away: [bool; LANES] = std::array::from_fn(|k| {
                    let (dx, dy) = (p[0] - l.x[k], p[1] - l.y[k]);
                    let t = least(most((dx * l.u[k] + dy * l.v[k]) * l.inverse[k], from), to);
                    let (ex, ey) = (dx - l.u[k] * t, dy - l.v[k] * t);
                    let limit = l.held[k] + r + l.growth[k] * to + SURE;
                    ex * ex + ey * ey > limit * limit
                });
                if away != [true; LANES] {
                    for (near, _) in self.near[LANES * i..].iter().zip(away).filter(|(_, away)| !away) {
                        visit(near, (p, r));
                    }
                }
            }
        }
    }

    /// The first lanes, those that matter where rooms have become less by at most `spent` m.
    fn mattering(&self, spent: f64) -> &[Lane] {
        let away = |l: &Lane| l.room > spent;
        &self.lanes[..self.lanes.iter().position(away).unwrap_or(self.lanes.len())]
    }

    /// Is the disc of radius `r` around `p` at least so far from all that movers could reach after `t` s at constant velocity and `more` s of any motion? A no may be
    /// wrong. In a part rooms have become less by at most `spent` m.
    #[inline]
    pub fn surely_beyond(&self, (p, r): (Point, f64), [t, more]: [f64; 2], spent: f64) -> bool {
        self.mattering(spent).iter().all(|l| {
            let mut free = true;
            for k in 0..LANES {
                let (dx, dy) = (p[0] - l.x[k] - l.u[k] * t, p[1] - l.y[k] - l.v[k] * t);
                let limit = l.radius[k] + l.doubt[k] + l.bound[k] * more + r + SURE;
                free &= dx * dx + dy * dy > limit * limit;
            }
            free
        })
    }

    /// As [`Crowd::surely_beyond`] for a disc of radius `r` and a distance of `least` m, and right.
    #[inline]
    pub fn beyond(&self, (p, r): (Point, f64), [t, more]: [f64; 2], least: f64, spent: f64) -> bool {
        self.surely_beyond((p, r + least), [t, more], spent)
            || self.near.iter().take(LANES * self.mattering(spent).len()).all(|n| {
                let room = n.distance(p, t) - n.track.doubt - n.track.bound * more - r;
                room >= least || room.is_nan()
            })
    }
}

/// The lesser; the second where the first is not a number.
#[inline]
fn least(a: f64, b: f64) -> f64 {
    if a < b { a } else { b }
}

/// The greater; the second where the first is not a number.
#[inline]
fn most(a: f64, b: f64) -> f64 {
    if a > b { a } else { b }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::drive::Outline;
    use proptest::prelude::*;
    use rand::RngExt;
    use rand_chacha::ChaCha8Rng;
    use rand_chacha::rand_core::SeedableRng;

    fn track(id: usize, rng: &mut ChaCha8Rng) -> Track {
        let mut any = |half: f64| rng.random_range(-half..half);
        let corners = vec![[-0.3, -0.2], [0.4, -0.2], [0.1, 0.5]];
        let points = if any(1.0) < 0.0 { corners } else { vec![[0.0; 2]] };
        let outline = Outline { points, radius: any(0.3).abs() };
        Track { id, outline, position: [any(6.0), any(6.0)], velocity: [any(1.5), any(1.5)], bound: 1.5 + any(1.5), doubt: any(0.2).abs() }
    }

    fn near(track: Track, rng: &mut ChaCha8Rng) -> Near<'static> {
        let (speed, radius) = (track.velocity[0].hypot(track.velocity[1]), track.outline.circumscribed());
        let [keep, growth, lively] = [0.2, 0.05, 1.0].map(|most| rng.random_range(0.0..most));
        Near { track: Box::leak(Box::new(track)), radius, speed, keep, growth, lively }
    }

    proptest! {
        #![proptest_config(ProptestConfig::with_cases(200))]
        #[test]
        fn the_part_of_a_crowd_that_matters_tells_what_all_of_it_tell(seed in 0..u64::MAX, n in 1..16_usize, from in 0.0..3.0_f64, span in 0.2..2.0_f64) {
            let mut rng = ChaCha8Rng::seed_from_u64(seed);
            let movers = (0..n).map(|id| near(track(id, &mut rng), &mut rng)).collect();
            let all = Crowd::new(movers);
            let (v, moves, more, length) = (1.0, 1.4, 1.2, 0.6);
            let discs = |p: Point| [([p[0] - 0.2, p[1]], 0.25), ([p[0] + 0.2, p[1] + 0.1], 0.3)].into_iter();
            let [mut on, mut stops] = [Crowd::new(Vec::new()), Crowd::new(Vec::new())];
            all.part(&discs([0.0; 2]), [from, from + span], [v, moves], &mut on);
            all.threats(([0.0; 2], 0.5 + 0.05 + length), [from, from + span], [moves, more], &mut stops);
            let (mut p, mut driven, steps) = ([0.0; 2], 0.0, 12);
            for k in 0..=steps {
                let t = f64::from(k) * span / f64::from(steps);
                let (found, exact) = (on.around(discs(p), (from + t, on.spent(driven, t)), v), all.around(discs(p), (from + t, 0.0), v));
                prop_assert_eq!([found.room, found.safe, found.close], [exact.room, exact.safe, exact.close]);
                let stop = [p[0] + rng.random_range(0.0..length), p[1]];
                let time = [from + t, rng.random_range(0.0..more)];
                let spent = stops.spent(driven, t);
                prop_assert_eq!(stops.beyond((stop, 0.5), time, 0.05, spent), all.beyond((stop, 0.5), time, 0.05, 0.0));
                let (angle, far) = (rng.random_range(0.0..6.3_f64), moves * span / f64::from(steps) * rng.random_range(0.0..1.0));
                (p, driven) = ([p[0] + far * angle.cos(), p[1] + far * angle.sin()], driven + far);
            }
        }
    }
}
