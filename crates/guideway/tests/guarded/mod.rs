//! A closed loop of random rooms, footprints, plants and movers, judged by code of its own.

use guideway::Point;
use guideway::context::Context;
use guideway::drive::{Command, Course, Decision, Guide, Motion, Outline, Plant, Robot, Setup, Track, Unicycle, controller};
use guideway::timing::State;
use guideway::world::{Footprint, Shape, World};
use rand::RngExt;
use rand_chacha::ChaCha8Rng;
use rand_chacha::rand_core::SeedableRng;
use std::f64::consts::{PI, TAU};
use std::sync::Arc;

const SIDE: f64 = 8.0;
/// Steps of the judge, s.
const FINE: f64 = 0.005;
/// Steps in one room.
const STEPS: u64 = 500;

/// What happened.
#[derive(Debug, Default, Clone)]
pub struct Tally {
    pub steps: u64,
    pub moving: u64,
    pub parked: u64,
    pub metres: f64,
    /// The first collision while moving.
    pub first: Option<String>,
}

impl Tally {
    pub fn add(mut self, other: Self) -> Self {
        self.steps += other.steps;
        self.moving += other.moving;
        self.parked += other.parked;
        self.metres += other.metres;
        self.first = self.first.or(other.first);
        self
    }
}

impl Tally {
    /// What a moving robot has met. Whoever runs into a standing one vanishes, far away.
    fn judge(&mut self, m: &Motion, (world, footprint): (&World, &Footprint), movers: &mut [Wanderer]) -> Option<&'static str> {
        let moving = m.v.abs() > 0.01 || m.w.abs() > 0.01;
        if moving && !world.pose_free(footprint, m.pose, 0.0) {
            return Some("static");
        }
        for mover in movers.iter_mut().filter(|mover| distance(footprint, m.pose, mover.at) < mover.radius) {
            if moving {
                return Some("mover");
            }
            self.parked += 1;
            mover.at = [100.0, 100.0];
        }
        None
    }
}

/// A disc that changes its velocity whenever it likes.
struct Wanderer {
    at: Point,
    velocity: Point,
    radius: f64,
    bound: f64,
    next: f64,
}

impl Wanderer {
    fn draw(rng: &mut ChaCha8Rng, at: Point) -> Self {
        let bound = rng.random_range(0.1..1.2);
        Self { at, velocity: [0.0; 2], radius: rng.random_range(0.1..0.5), bound, next: 0.0 }
    }

    /// Goes on for `h` s; at random, and half of the time at the robot, it turns.
    fn go(&mut self, rng: &mut ChaCha8Rng, (t, h): (f64, f64), robot: Point) {
        if t >= self.next {
            self.next = t + rng.random_range(0.1..3.0);
            let at_it = (robot[1] - self.at[1]).atan2(robot[0] - self.at[0]);
            let angle = if rng.random::<f64>() < 0.5 { at_it } else { rng.random_range(-PI..PI) };
            let speed = self.bound * if rng.random::<f64>() < 0.5 { 1.0 } else { rng.random::<f64>() };
            self.velocity = [speed * angle.cos(), speed * angle.sin()];
        }
        self.at = [self.at[0] + self.velocity[0] * h, self.at[1] + self.velocity[1] * h];
    }

    fn track(&self, id: usize) -> Track {
        let outline = Outline { points: vec![[0.0; 2]], radius: self.radius };
        Track { id, outline, position: self.at, velocity: self.velocity, bound: self.bound, doubt: 0.0 }
    }
}

fn footprint(rng: &mut ChaCha8Rng) -> Footprint {
    match rng.random_range(0..3) {
        0 => Footprint::Disc(rng.random_range(0.1..0.4)),
        1 => Footprint::Box([rng.random_range(0.3..1.0), rng.random_range(0.2..0.6)]),
        _ => {
            let (l, w) = (rng.random_range(0.2..0.6), rng.random_range(0.15..0.4));
            Footprint::Polygon(vec![[-l, -w], [0.5 * l, -w], [l, 0.0], [0.5 * l, w], [-l, w]])
        }
    }
}

/// Distance of a point to the footprint at a pose, m; 0 inside.
fn distance(footprint: &Footprint, [x, y, yaw]: [f64; 3], p: Point) -> f64 {
    let (dx, dy) = (p[0] - x, p[1] - y);
    let q = [dx * yaw.cos() + dy * yaw.sin(), dy * yaw.cos() - dx * yaw.sin()];
    let Some(corners) = footprint.corners() else { return (q[0].hypot(q[1]) - footprint.circumscribed()).max(0.0) };
    let n = corners.len();
    let edges = || (0..n).map(|i| (corners[i], corners[(i + 1) % n]));
    if edges().all(|(a, b)| (b[0] - a[0]) * (q[1] - a[1]) - (b[1] - a[1]) * (q[0] - a[0]) >= 0.0) {
        return 0.0;
    }
    let near = |(a, b): (Point, Point)| {
        let e = [b[0] - a[0], b[1] - a[1]];
        let r = (((q[0] - a[0]) * e[0] + (q[1] - a[1]) * e[1]) / (e[0] * e[0] + e[1] * e[1])).clamp(0.0, 1.0);
        (q[0] - a[0] - r * e[0]).hypot(q[1] - a[1] - r * e[1])
    };
    edges().map(near).fold(f64::INFINITY, f64::min)
}

fn straight(from: Point, to: Point) -> Arc<Guide> {
    let (dx, dy) = (to[0] - from[0], to[1] - from[1]);
    let (length, yaw) = (dx.hypot(dy).max(0.1), dy.atan2(dx));
    let state = |i: u32| {
        let s = length * f64::from(i) / 100.0;
        let pose = [from[0] + s * yaw.cos(), from[1] + s * yaw.sin(), yaw];
        State { t: s, s, pose, speed: 1.0, acceleration: 0.0, jerk: 0.0, curvature: 0.0, turn_rate: 0.0 }
    };
    let course = Course::from_states((0..=100).map(state).collect()).expect("a straight line");
    Arc::new(Guide::along(Arc::new(course)))
}

/// A room with obstacles, and the same obstacles for the judge, who lets the reference point come 0.05 m over the border.
fn room(rng: &mut ChaCha8Rng) -> [World; 2] {
    let n = rng.random_range(0..8);
    let shape = |rng: &mut ChaCha8Rng| {
        let (x, y, r) = (rng.random_range(0.0..SIDE), rng.random_range(0.0..SIDE), rng.random_range(0.1..0.7));
        let corner = |k: f64| [x + r * (k * TAU / 5.0).cos(), y + r * (k * TAU / 5.0).sin()];
        if rng.random() {
            Shape::Disc { center: [x, y], radius: r }
        } else {
            Shape::Polygon { points: (0..5).map(|k| corner(f64::from(k))).collect() }
        }
    };
    let shapes: Vec<Shape> = (0..n).map(|_| shape(rng)).collect();
    [0.0, 0.05].map(|b| World::from_shapes([-b, -b, SIDE + b, SIDE + b], shapes.clone(), 0.1).expect("a room"))
}

/// Everything moves for one fine step.
fn all_go(movers: &mut [Wanderer], rng: &mut ChaCha8Rng, t: f64, m: &Motion) {
    for mover in movers {
        mover.go(rng, (t, FINE), [m.pose[0], m.pose[1]]);
    }
}

/// Drives in one random room; `set` holds parameters of the controller.
pub fn drive(seed: u64, set: &serde_json::Value) -> Tally {
    let mut rng = ChaCha8Rng::seed_from_u64(seed);
    let ([world, judged], footprint) = (room(&mut rng), footprint(&mut rng));
    let world = Arc::new(world);
    let mut tally = Tally::default();
    let place = |rng: &mut ChaCha8Rng| [rng.random_range(0.3..SIDE - 0.3), rng.random_range(0.3..SIDE - 0.3)];
    let fits = |p: &Point, yaw: f64| world.pose_free(&footprint, [p[0], p[1], yaw], 0.05);
    let yaw = rng.random_range(-PI..PI);
    let Some(start) = (0..200).map(|_| place(&mut rng)).find(|p| fits(p, yaw)) else { return tally };
    let [speed, acceleration, deceleration] = [rng.random_range(0.4..2.0), rng.random_range(0.4..3.0), rng.random_range(0.4..3.0)];
    let robot = Robot {
        footprint: footprint.clone(),
        speed,
        acceleration,
        deceleration,
        jerk: 2.0 + 3.0 * (seed % 7) as f64,
        turn_rate: rng.random_range(0.8..2.5),
        turn_acceleration: rng.random_range(2.0..6.0),
    };
    let plant = Unicycle { lag_speed: rng.random_range(0.0..0.1), lag_turn: rng.random_range(0.0..0.08), ..Unicycle::default() };
    let mut plant = plant.place(&robot, [start[0], start[1], yaw], seed);
    let reach = footprint.circumscribed();
    let apart = |p: &Point| (p[0] - start[0]).hypot(p[1] - start[1]) > reach + 1.5;
    let mut movers: Vec<Wanderer> = Vec::new();
    for _ in 0..rng.random_range(0..7) {
        if let Some(p) = (0..50).map(|_| place(&mut rng)).find(apart) {
            movers.push(Wanderer::draw(&mut rng, p));
        }
    }
    let setup = Setup { world: Arc::clone(&world), robot, clearance: 0.1 };
    let mut driver = controller("improved-dwa", set.clone(), &setup).expect("the default controller");
    driver.follow(&straight(start, place(&mut rng)));
    let (period, mut ctx, mut t) = ([0.02, 0.05][rng.random_range(0..2)], Context::new(seed), 0.0);
    for step in 0..STEPS {
        let mut seen = plant.observe();
        (seen.time, seen.tracks) = (t, movers.iter().enumerate().map(|(i, m)| m.track(i)).collect());
        let command = match driver.decide(&seen, &mut ctx) {
            Decision::Drive(command) => command,
            Decision::Stop(_) | Decision::Replan(_) => Command::default(),
        };
        for _ in 0..(period / FINE).round() as u32 {
            plant.step(command, FINE);
            let m = plant.motion();
            all_go(&mut movers, &mut rng, t, &m);
            t += FINE;
            tally.metres += m.v.abs() * FINE;
            if let Some(with) = tally.judge(&m, (&judged, &footprint), &mut movers) {
                tally.moving += 1;
                tally.first = Some(format!("seed {seed}, {t:.2} s: {with}, {m:?}"));
                return tally;
            }
        }
        tally.steps += 1;
        if step % 150 == 149 {
            let m = plant.motion();
            driver.follow(&straight([m.pose[0], m.pose[1]], place(&mut rng)));
        }
    }
    tally
}
