//! The upper of the two layers while the robot drives: when a new plan is needed, what is in its way, and whether it is taken.
//!
//! Source: \[lu2025\] for the triggers, the tabu places and their expiry. Departures: counts of control steps are times (five periods of the source's 0.1 s are 0.5 s);
//! a way that a newly seen obstacle blocks is replaced before the robot stands in front of it, at most five times a second; a plan that is not needed is only taken
//! where it is clearly shorter, so that the robot does not waver between equal ways.

use super::ask::{Ask, asks};
use super::{Course, Decision, Delivery, Event, Found, Guide, Observation, Passing, Reason, Request, Robot, SubGoals, Track};
use crate::Point;
use crate::context::Context;
use crate::error::PlanError;
use crate::query::Query;
use crate::timing::Trajectory;
use crate::world::World;
use crate::world::shape::distance;
use std::sync::Arc;

/// The way counts as blocked after so long without a free command, s.
const BLOCKED: f64 = 0.5;
/// A robot slower than this has stopped, m/s.
const SLOW: f64 = 0.1;
/// A stop this near to the end of the course is no block unless something stands there, m.
const NEAR_END: f64 = 0.3;
/// A tabu place expires after so long, s.
const TABU: f64 = 10.0;
/// A sub-goal may be missed so often.
const MISSES: u32 = 3;
/// The cost that is left may exceed the one when the plan was made by this factor and by so much, m.
const DEARER: f64 = 1.5;
const LEAST: f64 = 0.5;
/// A tabu place is another one from this distance on, m.
const MOVED: f64 = 0.1;
/// Time between plans for stops that nothing in particular causes, s.
const UNPLACED: f64 = 3.0;
/// A plan that is not needed is taken if it is shorter than this share of what is left of the old one.
const BETTER: f64 = 0.9;
/// Shortest time between two plans where the course is blocked by what was seen newly, otherwise, and between looks for a better way, s.
const AGAIN: f64 = 0.2;
const RETRY: f64 = 1.0;
const REVIEW: f64 = 2.0;
/// Movers slower than this are in the way of plans, m/s, if they are within so many m.
const STANDING: f64 = 0.1;
const NEARBY: f64 = 6.0;
/// Samples of the course ahead that are looked up in a changed world are so far apart, m.
const APART: f64 = 0.05;
/// Room beyond what is asked for that such a look tells, m.
const LOOK: f64 = 0.5;
/// While a plan is made the robot brakes before a blocked place so much earlier than it has to, s and m.
const AHEAD: (f64, f64) = (0.2, 0.1);
/// A plan that took time is joined where the robot is by then, if that is no farther from it, m; one that it has hardly begun is driven from its start.
const STRAY: f64 = 0.3;
const BEGUN: f64 = 0.05;

/// Plans and times a new motion; owns or borrows what it needs.
pub type OwnReplanner<'a> = dyn Fn(&Ask, &mut Context) -> Result<Trajectory, PlanError> + Send + 'a;

/// Why a plan is asked for.
#[derive(Clone, Copy, PartialEq)]
enum Need {
    /// The robot stops.
    Stops,
    /// The robot cannot go on as planned, but is rolling.
    Must,
    /// There may be something better.
    May,
}

/// A plan that is being made.
struct Pending {
    why: String,
    need: Need,
    /// When it was asked for, s.
    asked: f64,
    number: u64,
    /// What nobody has begun with yet.
    request: Option<Request>,
    found: Option<Found>,
}

/// A place that plans keep off until it expires.
struct Tabu {
    place: (Point, f64),
    until: f64,
}

/// The layer above a controller.
pub(super) struct Navigator<'a> {
    query: Query,
    robot: Robot,
    replanner: Option<Box<OwnReplanner<'a>>>,
    /// When plans can be driven.
    pub delivery: Delivery,
    pending: Option<Pending>,
    /// Why a plan is to be made from rest, where the last one came too late for where the robot had gone meanwhile.
    rest: Option<String>,
    guide: Arc<Guide>,
    sub_goals: SubGoals,
    /// Arc length reached, m.
    s: f64,
    /// Cost-to-go when the plan was made, m.
    cost: f64,
    /// Radius of the disc that the course was planned for, m.
    radius: f64,
    blocked_since: Option<f64>,
    tabu: Vec<Tabu>,
    /// Times of the last attempt and of the last look for a better way, s.
    tried: f64,
    reviewed: f64,
    /// What was known when the course was looked at last.
    known: Option<Arc<World>>,
    /// Arc length at which the course was blocked then, if it was, m.
    block: Option<f64>,
    /// Why the last attempt failed.
    failed: Option<String>,
    /// Is the course blocked by what does not move, and no other way known?
    lost: bool,
    attempts: u64,
    /// New plans taken.
    pub replans: u32,
    /// Wall-clock time of each attempt in this step, s.
    pub seconds: Vec<f64>,
    pub events: Vec<Event>,
}

impl<'a> Navigator<'a> {
    pub fn new(query: &Query, robot: &Robot, course: Arc<Course>, replanner: Option<Box<OwnReplanner<'a>>>) -> Self {
        let guide = Arc::new(Guide::within(course, query, robot));
        let mut navigator = Self {
            query: query.clone(),
            robot: robot.clone(),
            replanner,
            delivery: Delivery::AtOnce,
            pending: None,
            rest: None,
            sub_goals: SubGoals::new(&guide),
            guide,
            s: 0.0,
            cost: f64::INFINITY,
            radius: robot.footprint.circumscribed() + query.clearance,
            blocked_since: None,
            tabu: Vec::new(),
            tried: f64::NEG_INFINITY,
            reviewed: 0.0,
            known: None,
            block: None,
            failed: None,
            lost: false,
            attempts: 0,
            replans: 0,
            seconds: Vec::new(),
            events: Vec::new(),
        };
        navigator.cost = navigator.expected(query.start);
        navigator
    }

    pub fn guide(&self) -> &Arc<Guide> {
        &self.guide
    }

    /// Arc length reached, m.
    pub fn reached(&self) -> f64 {
        self.s
    }

    /// The sub-goal that the robot heads for, m.
    pub fn sub_goal(&self) -> Option<Point> {
        self.sub_goals.next()
    }

    /// Why the robot must not go on, if there is no way, or none yet.
    pub fn halt(&self, seen: &Observation) -> Option<Reason> {
        if let Some(why) = self.failed.as_deref().filter(|_| self.lost) {
            return Some(Reason::new(format!("no way to the goal ({why})")));
        }
        if self.rest.is_some() {
            return Some(Reason::new("waits for a plan from where it stands"));
        }
        self.pending.as_ref()?;
        let v = seen.v.abs();
        let need = self.robot.braking_distance(v) + AHEAD.0 * v + AHEAD.1;
        self.block.filter(|at| at - self.s <= need).map(|_| Reason::new("waits for a plan around what blocks the way"))
    }

    /// What is to be planned outside of the steps, once.
    pub fn request(&mut self) -> Option<Request> {
        self.pending.as_mut()?.request.take()
    }
    /// Is there such a thing?
    pub fn asks(&self) -> bool {
        self.pending.as_ref().is_some_and(|pending| pending.request.is_some())
    }
    /// What came of it; nothing happens if it is needed no more.
    pub fn found(&mut self, found: Found) {
        self.seconds.push(found.seconds);
        if let Some(pending) = self.pending.as_mut().filter(|pending| pending.number == found.number) {
            pending.found = Some(found);
        }
    }

    pub fn event(&mut self, t: f64, kind: &str, reason: impl Into<String>) {
        self.events.push(Event { t, kind: kind.into(), reason: reason.into() });
    }

    /// Before a decision: progress, expiry, and what was seen newly. True if there is a new guide.
    pub fn before(&mut self, seen: &Observation, ctx: &Context) -> bool {
        let p = [seen.pose[0], seen.pose[1]];
        if !p.iter().all(|v| v.is_finite()) {
            return false;
        }
        self.s = self.guide.course.project(p, self.s, self.s + 1.0).0;
        if self.arrived(seen) {
            return true;
        }
        self.settle(seen, ctx);
        if self.expire(seen) {
            self.event(seen.time, "expired", "a place is no longer tabu");
            if !self.lost && self.replan("the way may be free again", Need::May, seen, ctx) {
                return true;
            }
        }
        self.missed(p, seen, ctx) || self.dear(p, seen, ctx) || self.changed(seen, ctx) || self.retry(seen, ctx)
    }

    /// Passing of sub-goals.
    fn missed(&mut self, p: Point, seen: &Observation, ctx: &Context) -> bool {
        let Passing::Missed(times) = self.sub_goals.advance(p, self.s) else { return false };
        self.event(seen.time, "sub-goal missed", format!("{times} in a row"));
        times >= MISSES && self.due(seen.time, RETRY) && self.replan(&format!("a sub-goal was missed {times} times"), Need::Must, seen, ctx)
    }

    /// Growth of the cost that is left.
    fn dear(&mut self, p: Point, seen: &Observation, ctx: &Context) -> bool {
        let cost = self.expected(p);
        if !(cost.is_finite() && cost > DEARER * self.cost + LEAST && self.due(seen.time, RETRY)) {
            return false;
        }
        self.event(seen.time, "dear", format!("{cost:.2} m are left, {:.2} m when planned", self.cost));
        self.cost = cost;
        self.replan("the way has become dear", Need::Must, seen, ctx)
    }

    /// A changed world: is the course still free, and is there a better one?
    fn changed(&mut self, seen: &Observation, ctx: &Context) -> bool {
        let Some(known) = &seen.known else { return false };
        let looked = self.known.as_ref().is_some_and(|before| Arc::ptr_eq(before, known));
        if looked || !(self.pending.is_some() || self.due(seen.time, AGAIN)) {
            return false;
        }
        self.known = Some(Arc::clone(known));
        let blocked = self.obstructed(known, [seen.pose[0], seen.pose[1]]);
        self.block = blocked.map(|(at, _)| at);
        if let Some((_, [x, y])) = blocked {
            let found = self.replan(&format!("the way is blocked at ({x:.2}, {y:.2})"), Need::Must, seen, ctx);
            self.lost |= !found && self.pending.is_none();
            return found;
        }
        self.lost = false;
        if seen.time - self.reviewed < REVIEW {
            return false;
        }
        self.reviewed = seen.time;
        self.replan("there is a better way", Need::May, seen, ctx)
    }

    /// Another look for a way where there was none.
    fn retry(&mut self, seen: &Observation, ctx: &Context) -> bool {
        self.lost && self.due(seen.time, RETRY) && self.replan("there is a way again", Need::Stops, seen, ctx)
    }

    /// After a decision: a way that is blocked for long, or a controller that asks. True if there is a new guide.
    pub fn after(&mut self, seen: &Observation, decision: &Decision, ctx: &Context) -> bool {
        let (reason, asked) = match decision {
            Decision::Drive(_) => {
                self.blocked_since = None;
                return false;
            }
            Decision::Stop(reason) => (reason, false),
            Decision::Replan(reason) => (reason, true),
        };
        let since = *self.blocked_since.get_or_insert(seen.time);
        let end = self.guide.course.end().pose;
        let here = distance([seen.pose[0], seen.pose[1]], [end[0], end[1]]) < NEAR_END;
        let blocked = (reason.place.is_some() || !here) && seen.time - since >= BLOCKED && seen.v.abs() < SLOW && self.due(seen.time, RETRY);
        if !(asked || blocked) || self.busy(Need::Stops) {
            return false;
        }
        if blocked && !asked {
            self.event(seen.time, "blocked", reason.text.clone());
        }
        let news = reason.place.map_or(self.due(seen.time, UNPLACED), |place| self.forbid(place, seen.time));
        self.replan(&reason.text, if asked || news { Need::Stops } else { Need::May }, seen, ctx)
    }

    /// A place becomes tabu; true if it was not.
    fn forbid(&mut self, place: (Point, f64), t: f64) -> bool {
        let until = t + TABU;
        if let Some(known) = self.tabu.iter_mut().find(|tabu| distance(tabu.place.0, place.0) < MOVED) {
            known.until = until;
            return false;
        }
        let ([x, y], r) = place;
        self.event(t, "tabu", format!("a disc of {r:.2} m at ({x:.2}, {y:.2}) for {TABU} s"));
        self.tabu.push(Tabu { place, until });
        true
    }

    /// Ends what has expired, unless something still stands there; true if something has.
    fn expire(&mut self, seen: &Observation) -> bool {
        let standing: Vec<Point> = standing(seen).map(|track| track.position).collect();
        let before = self.tabu.len();
        self.tabu.retain_mut(|tabu| {
            let there = standing.iter().any(|p| distance(*p, tabu.place.0) < tabu.place.1.max(MOVED));
            if there && tabu.until <= seen.time {
                tabu.until = seen.time + TABU;
            }
            tabu.until > seen.time
        });
        self.tabu.len() < before
    }

    /// Is it so long since the last attempt?
    fn due(&self, t: f64, wait: f64) -> bool {
        t - self.tried >= wait
    }

    /// Cost to the goal as the guide has it, m.
    fn expected(&self, p: Point) -> f64 {
        self.guide.to_go.as_ref().map_or(f64::INFINITY, |field| field.at(p))
    }

    /// The first place of the course ahead at which a changed world leaves too little room, and its arc length.
    fn obstructed(&self, world: &World, p: Point) -> Option<(f64, Point)> {
        let (body, core) = (self.robot.footprint.circumscribed(), self.robot.footprint.inscribed());
        // Where the plan had room to spare, some of it may go; noise would else ask for a plan with every scan.
        let limit = if self.radius > body { body + 0.25 * (self.radius - body) } else { core + 0.5 * (self.radius - core).max(0.0) };
        let length = self.guide.course.length();
        let n = ((length - self.s) / APART).ceil().max(0.0) as usize;
        let mut places = self.guide.course.places((0..=n).map(|k| self.s + APART * k as f64));
        // Where there is more room than is asked for, the places that are nearer than that need no look.
        let (mut clear, mut last) = (0.0, p);
        places.find(|(_, q)| {
            clear -= distance(*q, last);
            last = *q;
            if clear >= 0.0 || distance(*q, p) <= 0.1 {
                return false;
            }
            let room = world.clearance_within(*q, limit + LOOK);
            clear = room.min(limit + LOOK) - limit;
            room < limit - 1e-9
        })
    }

    /// What stands in the way: tabu places and movers nearby that stand.
    fn obstacles(&self, seen: &Observation) -> Vec<(Point, f64)> {
        let standing = standing(seen).map(|t| (t.position, t.outline.circumscribed()));
        self.tabu.iter().map(|tabu| tabu.place).chain(standing).collect()
    }

    /// Is a plan being made that one of this need has to wait for? One that something forces does not wait for one that nothing does.
    fn busy(&self, need: Need) -> bool {
        self.pending.as_ref().is_some_and(|pending| need == Need::May || pending.need != Need::May)
    }

    /// Asks for a plan, and takes it if it is there at once and needed or clearly better. True if there is a new guide.
    fn replan(&mut self, why: &str, need: Need, seen: &Observation, ctx: &Context) -> bool {
        if self.busy(need) {
            return false;
        }
        if self.replanner.is_none() && self.delivery != Delivery::Elsewhere {
            self.tried = seen.time;
            if need != Need::May {
                self.fail(seen.time, "there is no replanner");
            }
            return false;
        }
        (self.tried, self.attempts) = (seen.time, self.attempts + 1);
        let request = self.draw_up(need, seen, ctx);
        let found = match (&self.replanner, self.delivery) {
            (Some(replanner), Delivery::AtOnce | Delivery::After(_)) => Some(request.solve(replanner)),
            _ => None,
        };
        self.seconds.extend(found.iter().map(|found| found.seconds));
        match found {
            Some(found) if self.delivery == Delivery::AtOnce => self.take(found, why, need, seen),
            found => {
                self.event(seen.time, "asked", why);
                let (number, request) = (request.number, found.is_none().then_some(request));
                self.pending = Some(Pending { why: why.into(), need, asked: seen.time, number, request, found });
                false
            }
        }
    }

    /// A plan from here, as far as the surroundings are known.
    fn draw_up(&self, need: Need, seen: &Observation, ctx: &Context) -> Request {
        let world = seen.known.as_ref().unwrap_or(&self.query.world);
        let extra = self.obstacles(seen);
        let asks = asks((&self.query, &self.robot), (seen, need != Need::Stops), world, (&self.guide.course, self.s), &extra);
        let most = if need == Need::May { BETTER * (self.guide.course.length() - self.s) } else { f64::INFINITY };
        let seed = ctx.seed().wrapping_add(self.attempts);
        Request { asks, most, robot: self.robot.clone(), seed, threads: ctx.threads(), number: self.attempts }
    }

    /// Takes a plan that is there by now. True if there is a new guide.
    fn arrived(&mut self, seen: &Observation) -> bool {
        let wait = if let Delivery::After(wait) = self.delivery { wait } else { 0.0 };
        let there = |pending: &mut Pending| pending.found.is_some() && seen.time - pending.asked >= wait - 1e-9;
        let Some(Pending { why, need, asked, found: Some(found), .. }) = self.pending.take_if(there) else { return false };
        self.rest = None;
        let p = [seen.pose[0], seen.pose[1]];
        let Found { guide: Ok(Some((mut guide, radius))), seconds, number } = found else { return self.take(found, &why, need, seen) };
        let (s, off) = guide.course.project(p, 0.0, self.robot.speed * (seen.time - asked) + 1.0);
        if off > STRAY {
            self.event(seen.time, "late", format!("a plan begins where the robot no longer is, {off:.2} m off"));
            self.rest = (need != Need::May).then_some(why);
            return false;
        }
        guide.from = if s > BEGUN { s } else { 0.0 };
        // What was seen since it was asked for it knows nothing of.
        self.known = None;
        self.take(Found { guide: Ok(Some((guide, radius))), seconds, number }, &why, need, seen)
    }

    /// Asks for the plan that is to be made from rest, once the robot rests.
    fn settle(&mut self, seen: &Observation, ctx: &Context) {
        if let Some(why) = self.rest.clone().filter(|_| seen.v.abs() < SLOW) {
            self.replan(&why, Need::Stops, seen, ctx);
        }
    }

    fn take(&mut self, found: Found, why: &str, need: Need, seen: &Observation) -> bool {
        match found.guide {
            Ok(Some((guide, radius))) => {
                self.guide = Arc::new(guide);
                self.sub_goals = SubGoals::new(&self.guide);
                (self.s, self.radius, self.blocked_since) = (self.guide.from, radius, None);
                (self.failed, self.lost, self.block) = (None, false, None);
                self.cost = self.expected([seen.pose[0], seen.pose[1]]);
                self.replans += 1;
                self.event(seen.time, "replan", why);
                true
            }
            Err(e) if need != Need::May => {
                self.fail(seen.time, e.name());
                self.lost |= self.block.is_some();
                false
            }
            _ => false,
        }
    }

    /// There is no plan; said once until there is one or another reason.
    fn fail(&mut self, t: f64, why: &str) {
        if self.failed.as_deref() != Some(why) {
            self.event(t, "no-plan", why);
            self.failed = Some(why.into());
        }
    }
}

/// Movers nearby that stand.
fn standing(seen: &Observation) -> impl Iterator<Item = &Track> {
    let p = [seen.pose[0], seen.pose[1]];
    seen.tracks.iter().filter(move |t| t.velocity[0].hypot(t.velocity[1]) < STANDING && distance(t.position, p) < NEARBY)
}
