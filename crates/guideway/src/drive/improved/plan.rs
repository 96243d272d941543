//! Our settings: the best sequence of manoeuvres over the next seconds, its first command only if a full brake after it is safe.

use super::ImprovedDwa;
use super::left::{Idle, NEAR_END, NEARER, known, left, nothing};
use crate::Point;
use crate::context::Context;
use crate::drive::body::Body;
use crate::drive::critics::{Candidate, Weights};
use crate::drive::dwa::{nearest, why};
use crate::drive::field::{Field, Margins, Met};
use crate::drive::filter::Filter;
use crate::drive::guard::{Bounds, Guard, State};
use crate::drive::local::Local;
use crate::drive::ramp::Ramp;
use crate::drive::rooms::Rooms;
use crate::drive::search::{Node, Plans, Search};
use crate::drive::ways::{Predictor, Sim, Way, escapes};
use crate::drive::{Command, Controller, Course, Decision, Guide, Observation, Pacing, Reason, Setup, Sketch};
use crate::world::World;
use crate::world::shape::wrap;
use std::sync::Arc;

/// Ends of the levels as shares of the horizon.
const LEVELS: [f64; 5] = [0.08, 0.2, 0.4, 0.66, 1.0];
/// Offsets (m) and shares of the reference speed of the first and of the later manoeuvres along the path.
const OFFSETS: [f64; 7] = [0.0, -0.35, 0.35, -0.7, 0.7, -1.1, 1.1];
const LATER: [f64; 3] = [0.0, -0.7, 0.7];
const SHARES: [f64; 2] = [1.0, 0.5];
/// Shares of the top speed and of the largest turn rate of the arcs.
const SPEEDS: [f64; 3] = [0.0, 0.4, 0.9];
const TURNS: [f64; 4] = [-0.9, -0.35, 0.35, 0.9];
/// Time that the place of a stop must stay free beyond the horizon, s.
const PARK: f64 = 2.5;
/// Distance from the path beyond which it costs no more, m.
const LIMIT: f64 = 2.0;
/// What is left on the way counts so much of what is left at its end.
const EARLY: f64 = 0.3;
/// Stops in predictions begin so much later (s) and keep so much more distance (m) than those that are guaranteed.
const SLOW: f64 = 0.05;
const SPARE: f64 = 0.04;
/// Margin of the search for a way out where all plans with full margins meet something, m.
const TIGHT: f64 = 0.02;
/// So near to the path the robot is on it, m.
const ON_IT: f64 = 0.3;
/// Distance to the end of the path that counts as there, and beside it, m.
const THERE: f64 = 0.03;
const BESIDE: f64 = 0.06;
/// Older looks at the surroundings are none, s.
const BLIND: f64 = 0.5;
/// Steps of a ramp until the period is known, and at most, s.
const FIRST: f64 = 0.01;
const LONGEST: f64 = 0.1;
/// Below this a base that has braked counts as standing, m/s.
const SLOWEST: f64 = 0.05;
/// Least share of the acceleration that is commanded where speeds are ramped.
const GENTLE: f64 = 0.8;
/// A command that does more than stop keeps so much more distance where speeds are ramped, so that noise does not forbid the soft stop after it, m.
const FIRM: f64 = 0.02;
/// Arcs in a sketch.
const FAN: usize = 12;

pub(super) fn build(p: ImprovedDwa, setup: &Setup) -> Box<dyn Controller> {
    let still = p.safety.unwrap_or((0.5 * setup.clearance).clamp(0.02, 0.1));
    let body = Body::of(&setup.robot.footprint);
    Box::new(Planning {
        margins: Margins { still, moving: p.safety.unwrap_or(0.1), growth: p.growth },
        weights: p.weights(),
        filter: Filter::new(p.trust.min(1.0)),
        arm: if body.round() { 0.0 } else { body.reach },
        setup: setup.clone(),
        p,
        body,
        guide: None,
        s: 0.0,
        best: (0.0, f64::NAN),
        last: Last { command: Command::default(), rate: 0.0, braked: true, side: None, time: f64::NAN },
        held: None,
        idle: Idle::new(),
        sketch: Sketch::default(),
        rooms: Rooms::default(),
    })
}

/// The static world, and lower bounds of its clearance.
type Known<'a> = (&'a World, &'a Rooms);

/// What was done before.
struct Last {
    command: Command,
    /// Rate of the commanded speed, m/s2.
    rate: f64,
    /// It was a full brake.
    braked: bool,
    side: Option<i32>,
    time: f64,
}

/// A command, and the ramp it lies on where speeds are ramped.
#[derive(Clone, Copy)]
struct Move {
    command: Command,
    ramp: Option<Ramp>,
    /// It is a stop on the ramp.
    brakes: bool,
}

impl Move {
    /// Does it ask the base to stand?
    fn stands(&self) -> bool {
        nothing(self.command) && self.ramp.is_none_or(Ramp::rests)
    }
}

struct Planning {
    p: ImprovedDwa,
    weights: Weights,
    setup: Setup,
    body: Body,
    margins: Margins,
    filter: Filter,
    arm: f64,
    guide: Option<Arc<Guide>>,
    /// Arc length of the robot's projection, m.
    s: f64,
    /// Arc length reached, m, and when, s.
    best: (f64, f64),
    last: Last,
    /// The manoeuvre that is held, and until when, s.
    held: Option<(f64, Way)>,
    idle: Idle,
    sketch: Sketch,
    rooms: Rooms,
}

impl Controller for Planning {
    fn follow(&mut self, guide: &Arc<Guide>) {
        self.guide = Some(Arc::clone(guide));
        (self.s, self.best, self.held) = (guide.from, (guide.from, f64::NAN), None);
        self.last.side = None;
    }

    fn decide(&mut self, seen: &Observation, _ctx: &mut Context) -> Decision {
        let (from, dt) = (self.ramp(seen).v, self.lapse(seen.time));
        let decision = self.decided(seen);
        self.last.braked = !matches!(decision, Decision::Drive(_));
        let next = if let Decision::Drive(command) = decision { command } else { Command::default() };
        self.last.rate = if self.last.braked { 0.0 } else { (next.v - from) / dt };
        (self.last.command, self.last.time) = (next, seen.time);
        self.idle.note(seen, next, self.p.horizon);
        decision
    }

    fn pacing(&self) -> Pacing {
        if self.p.jerk_limited { Pacing::Eased } else { Pacing::Judged }
    }

    fn trace(&self) -> Option<Sketch> {
        Some(self.sketch.clone())
    }
}

impl Planning {
    fn decided(&mut self, seen: &Observation) -> Decision {
        let Some(guide) = self.guide.clone() else { return Decision::Stop(Reason::new("no course to follow")) };
        if !seen.pose.iter().chain([&seen.v, &seen.w, &seen.time]).all(|x| x.is_finite()) {
            return Decision::Stop(Reason::new("the estimate of the robot's state is no number"));
        }
        if seen.age > BLIND {
            return Decision::Stop(Reason::new(format!("nothing seen for {:.1} s", seen.age)));
        }
        let mut seen = seen.clone();
        self.filter.apply(&mut seen);
        let course = &guide.course;
        self.s = course.project([seen.pose[0], seen.pose[1]], (self.s - 1.0).max(0.0), self.s + 0.5).0;
        if self.best.1.is_nan() || self.s > self.best.0 + 0.1 {
            self.best = (self.s, seen.time);
        }
        let over = seen.time - self.best.1 > self.p.patience;
        let due = self.at_the_end(course, &seen).or_else(|| over.then(|| Decision::Replan(nearest(&seen))));
        self.choose(&guide, &seen, due)
    }

    /// At the last point: the last turn in place, then rest.
    fn at_the_end(&self, course: &Course, seen: &Observation) -> Option<Decision> {
        let end = course.end().pose;
        if course.length() - self.s > THERE || off(end, seen) > BESIDE {
            return None;
        }
        let arrival = course.states().iter().rev().find(|q| q.s < course.length() - 1e-6).map_or(end[2], |q| q.pose[2]);
        let turn = wrap(end[2] - seen.pose[2]);
        if wrap(end[2] - arrival).abs() > 0.05 && turn.abs() > 0.03 && seen.v < 0.1 {
            let rate = self.setup.robot.turn_rate;
            return Some(Decision::Drive(Command { v: 0.0, w: (2.0 * turn).clamp(-rate, rate) }));
        }
        Some(Decision::Stop(Reason::new("at the end of the path")))
    }

    fn choose(&mut self, guide: &Guide, seen: &Observation, due: Option<Decision>) -> Decision {
        let world = seen.known.clone().unwrap_or_else(|| Arc::clone(&self.setup.world));
        let mut rooms = std::mem::take(&mut self.rooms);
        rooms.look(&world, [seen.pose[0], seen.pose[1]], self.setup.robot.speed * self.p.horizon + self.body.reach);
        let decision = self.chosen(guide, seen, due, (&rooms, &world));
        self.rooms = rooms;
        decision
    }

    fn chosen(&mut self, guide: &Guide, seen: &Observation, due: Option<Decision>, (rooms, world): (&Rooms, &World)) -> Decision {
        let robot = &self.setup.robot.clone();
        let body = &self.body.clone();
        let field = Field::new(world, robot, body, seen, (self.margins, self.p.horizon + PARK)).with_rooms(rooms);
        let hold = if self.last.time.is_nan() { self.p.period } else { (seen.time - self.last.time).clamp(self.p.period, 1.0) };
        let lag = [self.p.lag_speed, self.p.lag_turn];
        let bounds = Bounds { lag, delay: self.p.delay, hold, error: self.p.error, drift: self.p.drift };
        let now = State { pose: seen.pose, v: seen.v, w: seen.w };
        let guard = Guard::new((&field, self.arm), robot, bounds, now, self.last.command);
        if let Some(decision) = due {
            return self.eased(decision, &guard, seen);
        }
        let back = self.s.min(1.0);
        let local = Local::new(&guide.course, self.s - back, back + robot.speed * (self.p.horizon + 0.5) + 0.5);
        // A ramp answers like a base that is so much slower.
        let more = if self.p.jerk_limited { 0.5 * robot.acceleration.max(robot.deceleration) / robot.jerk } else { 0.0 };
        let stop = [hold + self.p.delay + more + SLOW, self.p.error + SPARE];
        let predictor =
            Predictor { field: &field, local: &local, robot, lag: [lag[0] + more, lag[1]], arm: self.arm, limit: LIMIT, stop, early: more };
        let start = guard.ahead(self.p.delay);
        let mark = local.nearest((back / 0.05) as usize, [start.pose[0], start.pose[1]]);
        let start = Sim { pose: start.pose, v: start.v, w: start.w, mark };
        if let Some((until, way)) = self.held
            && (1e-9..=self.p.period).contains(&(until - seen.time))
        {
            let step = self.asked(&predictor, way, &start, seen);
            if self.allowed(&guard, step).is_ok() {
                return Decision::Drive(step.command);
            }
        }
        if let Some(decision) = self.undisturbed(&predictor, &guard, &start, seen) {
            return decision;
        }
        let firsts = self.firsts();
        let plans = self.search(&predictor, start, (&firsts, false), guide);
        if let Some(decision) = self.pick((&plans, &firsts, true), &predictor, &guard, (&start, seen)) {
            return decision;
        }
        self.escape(guide, (world, rooms), (predictor, &guard), (start, seen))
    }

    /// Where all plans with full margins meet something: the best way out with small ones.
    fn escape(&mut self, guide: &Guide, (world, rooms): Known, (before, guard): (Predictor, &Guard), (start, seen): (Sim, &Observation)) -> Decision {
        let (robot, body) = (before.robot, &self.body.clone());
        let tight = Margins { still: self.margins.still.min(TIGHT), moving: TIGHT, growth: 0.0 };
        let field = Field::new(world, robot, body, seen, (tight, self.p.horizon + PARK)).with_rooms(rooms);
        let stop = [before.stop[0] - SLOW, self.p.error + TIGHT];
        let predictor = Predictor { field: &field, stop, ..before };
        let firsts = escapes(robot, self.p.reverse, &start, 0);
        let plans = self.search(&predictor, start, (&firsts, true), guide);
        let decision = self.pick((&plans, &firsts, false), &predictor, guard, (&start, seen));
        decision.unwrap_or_else(|| Decision::Stop(why(None, seen)))
    }

    /// Along the path, where nothing is near on the way: no search is needed.
    fn undisturbed(&mut self, predictor: &Predictor, guard: &Guard, start: &Sim, seen: &Observation) -> Option<Decision> {
        let way = Way::Follow { share: 1.0, offset: 0.0 };
        let place = |sim: &Sim| predictor.local.relative(sim.mark, sim.pose);
        let ([s, lateral], left) = (place(start), predictor.local.length - place(start)[0]);
        if lateral.abs() > ON_IT || left < NEAR_END {
            return None;
        }
        let mut found = Vec::new();
        predictor.run(&[way], start, &predictor.pace(start, [0.0, self.p.horizon]), [predictor.field.crowd().0; 2], &mut found);
        let on = found.pop()?;
        let exposed = [predictor.exposure(start, 0.0), predictor.exposure(&on.end, self.p.horizon)].iter().flatten().any(|e| *e > 0.0);
        if exposed || on.contact.is_some() || on.late.is_some() || on.near > 0.0 || place(&on.end)[0] - s < 0.5 * NEAR_END {
            return None;
        }
        let step = self.asked(predictor, way, start, seen);
        let rest = self.allowed(guard, step).ok()?;
        self.sketch.chosen = vec![[start.pose[0], start.pose[1]], [on.end.pose[0], on.end.pose[1]]];
        self.sketch.fan.clear();
        self.sketch.discs = predictor.field.discs(rest);
        (self.last.side, self.held) = (Some(way.side()), None);
        Some(Decision::Drive(step.command))
    }

    /// The best plan whose first command is safe; where only `good` ones count, `None` if all that are meet something.
    fn pick(
        &mut self,
        (plans, firsts, good): (&Plans, &[Way], bool),
        predictor: &Predictor,
        guard: &Guard,
        (start, seen): (&Sim, &Observation),
    ) -> Option<Decision> {
        self.sketch.fan = plans.best.iter().take(FAN).map(|i| plans.line(*i)).collect();
        self.sketch.chosen.clear();
        self.sketch.discs.clear();
        let planned = plans.best.iter().map(|i| plans.node(*i)).find(|n| n.first == 0).and_then(|n| n.met);
        let mut refused = None;
        let mut order: Vec<usize> = plans.best.iter().copied().filter(|i| !(good && plans.node(*i).lost)).collect();
        if good && self.idle.urges(seen) {
            let guide = self.guide.as_deref().and_then(|guide| guide.to_go.as_deref());
            let to_go = known(guide, [start.pose[0], start.pose[1]]);
            let stands = |i: usize| self.asked(predictor, firsts[plans.node(i).first], start, seen).stands();
            let enough = left(start, predictor.local, to_go) - NEARER;
            order.sort_by_key(|i| plans.node(*i).rest > enough || stands(*i));
        }
        for i in order {
            let way = firsts[plans.node(i).first];
            let step = self.asked(predictor, way, start, seen);
            match self.allowed(guard, step) {
                Err(met) => refused = refused.or(Some(met)),
                Ok(rest) => {
                    self.sketch.chosen = plans.line(i);
                    self.sketch.discs = predictor.field.discs(rest);
                    self.last.side = Some(way.side());
                    if step.stands() {
                        self.held = None;
                        return Some(Decision::Stop(why(refused.or(planned).or(plans.node(i).met), seen)));
                    }
                    self.held = Some((seen.time + self.p.period, way));
                    return Some(Decision::Drive(step.command));
                }
            }
        }
        self.last.side = None;
        if good {
            return None;
        }
        Some(self.eased(Decision::Stop(unsafe_stop(refused, seen)), guard, seen))
    }

    /// Is a command safe, with the full brake and, on a ramp, with the soft one? The time until the base stands after it, s.
    fn allowed(&self, guard: &Guard, step: Move) -> Result<f64, Met> {
        if !self.p.guarantee {
            return Ok(0.0);
        }
        let spare = if step.ramp.is_none() || step.brakes { 0.0 } else { FIRM };
        let soft = if step.ramp.is_some() { guard.certify(step.command, step.ramp, spare)? } else { 0.0 };
        Ok(guard.certify(step.command, None, spare)?.max(soft))
    }

    /// What a manoeuvre asks for now, within the speed that is allowed and on the ramp.
    fn asked(&self, predictor: &Predictor, way: Way, start: &Sim, seen: &Observation) -> Move {
        let (v, w) = predictor.wanted(way, start);
        let step = self.ramped(seen.within(&self.setup.robot, Command { v, w }), seen);
        // Where the ramp needs all that is left of the path to stop, it begins to.
        let left = (predictor.local.length - predictor.local.relative(start.mark, start.pose)[0]).max(0.0);
        let long = |ramp: Ramp| ramp.v > SLOWEST && ramp.stop(self.lapse(seen.time)) + self.p.lag_speed * ramp.v > left;
        if step.ramp.is_some_and(long) {
            let stop = self.ramped(Command::default(), seen);
            return Move { command: Command { w, ..stop.command }, ..stop };
        }
        step
    }

    fn ramped(&self, wanted: Command, seen: &Observation) -> Move {
        if !self.p.jerk_limited {
            return Move { command: wanted, ramp: None, brakes: false };
        }
        let (mut ramp, brakes) = (self.ramp(seen), nothing(wanted));
        let v = ramp.step(if brakes { 0.0 } else { wanted.v }, self.lapse(seen.time));
        Move { command: Command { v, w: wanted.w }, ramp: Some(ramp), brakes }
    }

    /// The ramp of the commanded speed as the last step left it; after a full brake it begins at the speed of the base.
    fn ramp(&self, seen: &Observation) -> Ramp {
        let robot = &self.setup.robot;
        // Speeds that are commanded in steps of h make a base with lag T change its speed faster for a moment, by (h / T) / (1 - exp(-h / T)).
        let x = self.lapse(seen.time) / self.p.lag_speed.max(1e-9);
        let gentle = (-(-x).exp_m1() / x).max(GENTLE);
        let v = if !self.last.braked || seen.v.abs() < SLOWEST { self.last.command.v } else { seen.v };
        Ramp { a: self.last.rate, ..Ramp::at(v, [gentle * robot.acceleration, gentle * robot.deceleration], robot.jerk) }
    }

    /// Time since the last step, s.
    fn lapse(&self, t: f64) -> f64 {
        let dt = t - self.last.time;
        if dt.is_nan() { FIRST } else { dt.clamp(1e-3, LONGEST) }
    }

    /// A decision that no search has made: if it is safe, and on the ramp down to rest first.
    fn eased(&mut self, decision: Decision, guard: &Guard, seen: &Observation) -> Decision {
        self.held = None;
        let (wanted, drives) = if let Decision::Drive(command) = decision { (command, true) } else { (Command::default(), false) };
        let step = self.ramped(wanted, seen);
        if !drives && step.ramp.is_none_or(Ramp::rests) {
            if matches!(decision, Decision::Replan(_)) {
                self.best.1 = seen.time;
            }
            return decision;
        }
        match self.allowed(guard, step) {
            Ok(_) => Decision::Drive(step.command),
            Err(met) => Decision::Stop(unsafe_stop(Some(met), seen)),
        }
    }

    fn search(&self, predictor: &Predictor, start: Sim, (firsts, escape): (&[Way], bool), guide: &Guide) -> Plans {
        let levels = LEVELS.map(|share| share * self.p.horizon);
        let search = Search { predictor, levels: &levels, beam: self.p.beam as usize, park: PARK };
        let commands: Vec<(f64, f64)> = firsts.iter().map(|way| predictor.wanted(*way, &start)).collect();
        let mut ways = |node: &Node, level: usize, list: &mut Vec<Way>| match level {
            0 => list.extend_from_slice(firsts),
            _ if escape => list.extend(escapes(predictor.robot, self.p.reverse, &node.sim, level)),
            _ => self.later(&node.sim, list),
        };
        let to_go = known(guide.to_go.as_deref(), [start.pose[0], start.pose[1]]);
        let left = |sim: &Sim| left(sim, predictor.local, to_go);
        let end = guide.course.end().pose;
        let score = |node: &Node| {
            let way = (firsts[node.first], commands[node.first]);
            self.weights.total(&self.candidate(node, predictor.local, way, [end[0], end[1]]))
        };
        search.run(start, &mut ways, &left, &score)
    }

    /// What may be done now, the path itself first.
    fn firsts(&self) -> Vec<Way> {
        let (top, rate) = (self.setup.robot.speed, self.setup.robot.turn_rate);
        let mut all: Vec<Way> = Vec::with_capacity(40);
        all.extend(OFFSETS.iter().flat_map(|offset| SHARES.map(|share| Way::Follow { share, offset: *offset })));
        all.push(Way::Arc { v: 0.0, w: 0.0 });
        all.extend(SPEEDS.iter().flat_map(|v| TURNS.map(|w| Way::Arc { v: v * top, w: w * rate })));
        all.extend([Way::Arc { v: 0.9 * top, w: 0.0 }, Way::Arc { v: 0.4 * top, w: 0.0 }]);
        if self.p.reverse > 0.0 {
            all.extend([0.0, -0.35, 0.35].map(|w| Way::Arc { v: -self.p.reverse.min(top), w: w * rate }));
        }
        all.extend([1.0, 0.4].map(|share| Way::Toward { v: share * top }));
        all
    }

    /// What may follow.
    fn later(&self, sim: &Sim, list: &mut Vec<Way>) {
        let (top, rate) = (self.setup.robot.speed, self.setup.robot.turn_rate);
        list.extend(LATER.iter().map(|offset| Way::Follow { share: 1.0, offset: *offset }));
        list.push(Way::Toward { v: 0.6 * top });
        list.push(Way::Follow { share: 0.5, offset: 0.0 });
        list.push(Way::Arc { v: 0.0, w: 0.0 });
        list.push(Way::Arc { v: 0.9 * top, w: 0.0 });
        list.extend([-0.5, 0.5].map(|w| Way::Arc { v: 0.7 * top, w: w * rate }));
        list.extend([-1.0, 1.0].map(|turn| Way::Heading { yaw: wrap(sim.pose[2] + turn * 1.5), v: 0.6 * top }));
        if self.p.reverse > 0.0 && sim.v < 0.1 {
            list.push(Way::Arc { v: -self.p.reverse.min(top), w: 0.0 });
        }
    }

    /// What the critics see of a plan.
    fn candidate(&self, node: &Node, local: &Local, (way, (v, w)): (Way, (f64, f64)), target: Point) -> Candidate {
        let sim = &node.sim;
        let lateral = local.relative(sim.mark, sim.pose)[1];
        let mark = local.mark(sim.mark);
        let along = if mark.s > local.length - 0.15 { sim.pose[2] } else { mark.yaw - (2.0 * lateral / (0.5 + sim.v.max(0.0))).atan() };
        Candidate {
            v,
            w,
            end: sim.pose,
            target,
            along,
            dist: 0.0,
            left: (node.rest + EARLY * node.left / node.t.max(1e-9)) / self.setup.robot.speed,
            aside: node.aside,
            close: node.near,
            exposed: node.exposed[0],
            turned: node.exposed[1],
            change: (v - self.last.command.v).abs() + 0.3 * (w - self.last.command.w).abs(),
            kept: self.last.side == Some(way.side()),
        }
    }
}

/// Distance from the end pose, m.
fn off(end: [f64; 3], seen: &Observation) -> f64 {
    (end[0] - seen.pose[0]).hypot(end[1] - seen.pose[1])
}

/// Not even braking is certain to be in time, or nothing else is.
fn unsafe_stop(met: Option<Met>, seen: &Observation) -> Reason {
    match met {
        Some(Met::Mover(id)) => match seen.tracks.iter().find(|t| t.id == id) {
            Some(track) => Reason::at(format!("mover {id} could be here before the robot stands"), track),
            None => Reason::new(format!("mover {id} could be here before the robot stands")),
        },
        other => why(other, seen),
    }
}
