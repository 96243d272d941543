use super::*;
use crate::drive::{Outline, Track};
use crate::world::{Footprint, Loop, Mover, Shape};

const DT: f64 = 0.05;

/// A lidar in a world with discs that move, at a pose that stays.
struct Room {
    world: Arc<World>,
    movers: Vec<Mover>,
    lidar: Lidar,
    rng: rand_chacha::ChaCha8Rng,
    eyes: Eyes,
    pose: [f64; 3],
    /// m/s, rad/s.
    speeds: [f64; 2],
}

impl Room {
    fn new(shapes: Vec<Shape>, movers: Vec<Mover>, map_known: bool) -> Self {
        let world = Arc::new(World::from_shapes([-6.0, -6.0, 6.0, 6.0], shapes, 0.05).unwrap());
        let lidar = Lidar::default();
        let eyes = Eyes::new(lidar, &world, map_known).unwrap();
        Self { world, movers, lidar, rng: Lidar::random(7), eyes, pose: [0.0; 3], speeds: [0.0; 2] }
    }

    fn scan(&mut self, t: f64) -> Scan {
        let there: Vec<(Outline, Point)> = self.movers.iter().map(|m| (Outline::of(&m.shape), m.at(t).0)).collect();
        self.lidar.scan(&self.world, &there, (self.pose, t), &mut self.rng)
    }

    fn look(&mut self, t: f64, scan: Option<Scan>) -> Observation {
        let mut seen = Observation::new(t, self.pose, self.speeds[0], self.speeds[1]);
        self.eyes.look(&mut seen, scan);
        seen
    }

    fn step(&mut self, t: f64) -> Observation {
        let scan = self.scan(t);
        self.look(t, Some(scan))
    }
}

fn disc(radius: f64, track: Vec<[f64; 3]>) -> Mover {
    Mover { shape: Footprint::Disc(radius), track, repeat: Loop::Shuttle, phase: 0.0, appears: None }
}

fn holds(track: &Track, mover: &Mover, t: f64) -> bool {
    distance(track.position, mover.at(t).0) + mover.shape.circumscribed() <= track.outline.radius + track.doubt
}

fn walls() -> Vec<Shape> {
    vec![
        Shape::polygon(vec![[-5.0, 4.0], [5.0, 4.0], [5.0, 4.2], [-5.0, 4.2]]).unwrap(),
        Shape::disc([-2.0, -2.0], 0.5).unwrap(),
        Shape::disc([2.5, -1.0], 0.075).unwrap(),
    ]
}

#[test]
fn a_mover_is_tracked_with_its_place_speed_and_size() {
    for (map_known, speed) in [(true, 0.3), (true, 1.0), (false, 0.5), (false, 1.5)] {
        let mover = disc(0.4, vec![[0.0, -3.0, 2.0], [6.0 / speed, 3.0, 2.0]]);
        let mut room = Room::new(walls(), vec![mover.clone()], map_known);
        let (mut good, mut held, mut n) = (0, 0, 0);
        for i in 0..(6.0 / speed / DT) as u32 {
            let t = DT * f64::from(i);
            let seen = room.step(t);
            if t < 1.5 {
                continue;
            }
            n += 1;
            let nearest = seen.tracks.iter().min_by(|a, b| distance(a.position, mover.at(t).0).total_cmp(&distance(b.position, mover.at(t).0)));
            let Some(track) = nearest else { continue };
            let off = distance(track.velocity, mover.at(t).1);
            good += u32::from(distance(track.position, mover.at(t).0) < 0.1 && off < 0.35 && (track.outline.radius - 0.4).abs() < 0.12);
            held += u32::from(holds(track, &mover, t));
            assert!(track.bound >= 1.0_f64.max(speed));
        }
        assert!(f64::from(good) > 0.95 * f64::from(n) && f64::from(held) > 0.99 * f64::from(n), "{map_known} {speed}: {good} and {held} of {n}");
    }
}

#[test]
fn what_the_map_shows_is_no_mover_and_what_rests_is_static() {
    let parked = disc(0.3, vec![[0.0, 2.0, 1.0]]);
    let mut room = Room::new(walls(), vec![parked.clone()], true);
    let mut seen = room.step(0.0);
    for i in 1..60 {
        seen = room.step(DT * f64::from(i));
        assert!(i > 14 || (seen.tracks.len() == 1 && seen.known.is_none() && holds(&seen.tracks[0], &parked, 0.0)));
    }
    assert!(seen.tracks.is_empty() && seen.age == 0.0, "{:?}", seen.tracks);
    let known = seen.known.unwrap();
    assert!(known.clearance([1.7, 0.85]) < 0.06 && known.shapes().len() == 3 && (known.clearance([-2.0, -3.0]) - 0.5).abs() < 1e-9);
    // It leaves: the map is as it was.
    room.movers.clear();
    (60..120).for_each(|i| drop(room.step(DT * f64::from(i))));
    let later = room.look(6.02, None);
    assert!((later.age - 0.07).abs() < 1e-9 && later.known.unwrap().grid().unwrap().blocked().is_empty());
}

#[test]
fn without_a_map_what_was_hit_is_blocked_and_nothing_else() {
    let mut room = Room::new(walls(), Vec::new(), false);
    let mut seen = room.step(0.0);
    for i in 1..40 {
        room.speeds = [0.5, 0.2];
        room.pose = crate::drive::arc(room.pose, 0.5, 0.2, DT);
        seen = room.step(DT * f64::from(i));
        assert!(seen.tracks.is_empty(), "{:?}", seen.tracks);
    }
    let known = seen.known.unwrap();
    let grid = known.grid().unwrap();
    let mut count = 0;
    for (y, x) in (0..grid.height()).flat_map(|y| (0..grid.width()).map(move |x| (y, x))) {
        if grid.blocked().at(x, y) {
            count += 1;
            // Half a diagonal of a cell and three sigma.
            assert!(room.world.clearance(grid.center([x, y])).abs() < 0.036 + 0.03, "{:?}", grid.center([x, y]));
        }
    }
    assert!(count > 150, "{count}");
    let (made, true_one) = (known.clearance([2.3, -0.8]), room.world.clearance([2.3, -0.8]));
    // A cell reaches a diagonal beyond what touches it.
    assert!(made < true_one + 0.02 && made > true_one - 0.09, "{made} {true_one}");
    assert!(grid.unknown().unwrap().at_or_zero(i64::from(grid.cell_at([0.0, 5.0]).unwrap()[0]), i64::from(grid.cell_at([0.0, 5.0]).unwrap()[1])));
}

#[test]
fn without_a_map_something_new_is_seen_at_once_and_becomes_static() {
    let mut room = Room::new(walls(), Vec::new(), false);
    for i in 0..40 {
        room.step(DT * f64::from(i));
    }
    let parked = disc(0.3, vec![[0.0, 1.5, 1.0]]);
    room.movers.push(parked.clone());
    let seen = room.step(2.0);
    assert!(seen.tracks.len() == 1 && holds(&seen.tracks[0], &parked, 0.0), "{:?}", seen.tracks);
    for i in 41..80 {
        room.step(DT * f64::from(i));
    }
    let seen = room.step(4.0);
    assert!(seen.tracks.is_empty() && seen.known.unwrap().clearance([1.2, 0.8]) < 0.06);
    // It leaves: the place becomes free.
    room.movers.clear();
    (81..140).for_each(|i| drop(room.step(DT * f64::from(i))));
    assert!(room.step(7.0).known.unwrap().clearance([1.5, 1.0]) > 0.9);
}

#[test]
fn the_known_world_is_made_anew_only_when_it_changes() {
    let mut room = Room::new(walls(), Vec::new(), false);
    room.lidar.noise = 0.0;
    for i in 0..30 {
        room.step(DT * f64::from(i));
    }
    let (a, b) = (room.step(1.5).known.unwrap(), room.step(1.55).known.unwrap());
    assert!(Arc::ptr_eq(&a, &b));
}

#[test]
fn a_silent_lidar_blinds_and_a_new_scan_gives_sight_back() {
    let mut room = Room::new(walls(), Vec::new(), true);
    assert!(room.look(0.0, None).age.is_infinite());
    assert_eq!(room.step(DT).age, 0.0);
    assert!((room.look(0.65, None).age - 0.6).abs() < 1e-9);
    // The same scan again is none.
    let old = room.scan(DT);
    assert!((room.look(0.7, Some(old)).age - 0.65).abs() < 1e-9);
    assert_eq!(room.step(0.75).age, 0.0);
}

#[test]
fn a_clock_that_jumps_forgets_movers_and_goes_on() {
    let mover = disc(0.4, vec![[0.0, -3.0, 2.0], [6.0, 3.0, 2.0]]);
    let mut room = Room::new(walls(), vec![mover], true);
    (0..20).for_each(|i| drop(room.step(DT * f64::from(i))));
    for jump in [50.0, 3.0, f64::NAN, 3.1] {
        let blind = room.look(jump, None);
        assert!(blind.age.is_infinite() || jump == 3.1, "{jump}: {}", blind.age);
        if jump.is_finite() {
            let seen = room.step(jump + DT);
            assert!(seen.age == 0.0 && seen.tracks.len() == 1);
        }
    }
}

#[test]
fn broken_scans_are_no_look() {
    let mut room = Room::new(walls(), Vec::new(), false);
    room.step(0.0);
    let good = room.scan(0.1);
    let broken: [fn(&mut Scan); 7] = [
        |s| s.ranges.fill(f64::NAN),
        |s| s.ranges.fill(-1.0),
        |s| s.ranges.fill(f64::NEG_INFINITY),
        |s| s.ranges.truncate(100),
        |s| s.ranges.push(1.0),
        |s| s.step = f64::NAN,
        |s| s.time = f64::NAN,
    ];
    for change in broken {
        let mut scan = good.clone();
        change(&mut scan);
        assert!((room.look(0.1, Some(scan)).age - 0.1).abs() < 1e-9);
    }
    // Rays without a measurement are left out; infinite and too long ones met nothing.
    let mut scan = good.clone();
    scan.ranges.iter_mut().take(170).enumerate().for_each(|(i, r)| *r = [f64::NAN, f64::INFINITY, -3.0, 1e300, f64::NEG_INFINITY][i % 5]);
    let seen = room.look(0.1, Some(scan));
    assert!(seen.age == 0.0 && seen.tracks.iter().all(|t| t.position.iter().all(|v| v.is_finite())));
    let mut seen = Observation::new(0.2, [f64::NAN, 0.0, 0.0], 0.0, 0.0);
    room.eyes.look(&mut seen, Some(good));
    assert!(seen.age.is_infinite());
}

#[test]
fn a_hidden_mover_is_remembered_for_a_while_and_a_vanished_one_is_not() {
    let mover = disc(0.3, vec![[0.0, 3.0, -3.0], [6.0, 3.0, 3.0]]);
    let mut room = Room::new(vec![Shape::disc([1.5, 0.0], 0.6).unwrap()], vec![mover], true);
    let ids = |seen: &Observation| seen.tracks.iter().map(|t| t.id).collect::<Vec<_>>();
    let mut last = Vec::new();
    for i in 0..120 {
        let seen = room.step(DT * f64::from(i));
        if !seen.tracks.is_empty() {
            last = ids(&seen);
        }
        assert!(seen.tracks.len() <= 2);
    }
    room.movers.clear();
    (120..126).for_each(|i| drop(room.step(DT * f64::from(i))));
    assert!(room.step(DT * 126.0).tracks.is_empty(), "{last:?}");
}

#[test]
fn the_top_speed_of_the_site_bounds_every_track() {
    let mover = disc(0.4, vec![[0.0, -3.0, 2.0], [6.0, 3.0, 2.0]]);
    let bounds = |top: Option<f64>| {
        let mut room = Room::new(walls(), vec![mover.clone()], true);
        room.eyes = room.eyes.with_mover_speed(top).unwrap();
        let seen: Vec<_> = (0..40).map(|i| room.step(DT * f64::from(i))).collect();
        seen.iter().flat_map(|s| s.tracks.iter().map(|t| (t.bound, t.velocity[0].hypot(t.velocity[1])))).collect::<Vec<_>>()
    };
    assert!(!bounds(Some(2.5)).is_empty() && bounds(Some(2.5)).iter().all(|b| b.0 == 2.5));
    // What is seen to be faster than was said is not believed to be slower; without a word it may become a fifth faster.
    assert!(bounds(Some(0.1)).iter().skip(20).all(|(bound, speed)| bound == speed && *speed > 0.5));
    assert!(bounds(None).iter().skip(20).all(|(bound, speed)| *bound == 1.0_f64.max(1.2 * speed)));
    for wrong in [-1.0, f64::NAN, f64::INFINITY, 1e9] {
        let room = Room::new(Vec::new(), Vec::new(), true);
        assert!(room.eyes.with_mover_speed(Some(wrong)).is_err(), "{wrong}");
    }
}

/// A disc of 0.4 m that follows corners at 1.8 m/s.
fn runner(corners: &[Point]) -> Mover {
    let mut track = vec![[0.0, corners[0][0], corners[0][1]]];
    for pair in corners.windows(2) {
        let t = track[track.len() - 1][0] + distance(pair[0], pair[1]) / 1.8;
        track.push([t, pair[1][0], pair[1][1]]);
    }
    disc(0.4, track)
}

#[test]
fn where_the_top_speed_is_known_a_runner_stays_in_its_disc_in_sharp_turns() {
    let mover = runner(&[[-3.0, 2.0], [0.0, 1.8], [1.5, 4.0], [3.0, 1.0], [2.0, -2.5], [-1.0, -2.0], [-3.0, -4.0], [-3.5, 0.0]]);
    let held = |top: Option<f64>| {
        let mut room = Room::new(Vec::new(), vec![mover.clone()], true);
        room.eyes = room.eyes.with_mover_speed(top).unwrap();
        let (mut held, mut ids) = (0, std::collections::BTreeSet::new());
        for i in 0..1200 {
            let t = 0.025 * f64::from(i);
            let seen = room.step(t);
            held += u32::from(i >= 40 && seen.tracks.iter().any(|track| holds(track, &mover, t)));
            ids.extend(seen.tracks.iter().map(|track| track.id));
        }
        (f64::from(held) / 1160.0, ids.len())
    };
    let (known, guessed) = (held(Some(1.8)), held(None));
    assert!(known.0 > 0.99 && known.1 == 1, "{known:?} {guessed:?}");
    assert!(guessed.0 < known.0 && guessed.1 > 1, "else there would be no need: {guessed:?}");
}

#[test]
fn where_the_top_speed_is_known_a_runner_that_is_hidden_may_be_anywhere_that_it_could_reach() {
    // It runs behind a pillar, turns there and comes back.
    let mover = runner(&[[3.5, -4.0], [3.5, 0.0]]);
    let mut room = Room::new(vec![Shape::disc([1.0, 0.0], 0.5).unwrap()], vec![mover.clone()], true);
    room.eyes = room.eyes.with_mover_speed(Some(1.8)).unwrap();
    let (mut hidden, mut ids) = (0, std::collections::BTreeSet::new());
    for i in 0..160 {
        let t = 0.025 * f64::from(i);
        let seen = room.step(t);
        if t > 0.5 {
            assert!(seen.tracks.iter().any(|track| holds(track, &mover, t)), "{t}: {:?}", seen.tracks);
            hidden += u32::from(seen.tracks.iter().all(|track| track.doubt > 0.5));
            ids.extend(seen.tracks.iter().map(|track| track.id));
        }
    }
    assert!(hidden > 20 && ids.len() == 1, "{hidden} {ids:?}");
}

#[test]
fn an_obstacle_on_the_robot_is_told() {
    // Beside the lidar it is a mover, over it there is nothing to be seen.
    let mut room = Room::new(Vec::new(), vec![disc(0.5, vec![[0.0, 0.6, 0.0]])], true);
    assert!(room.step(0.0).tracks.iter().any(|t| t.distance([0.15, 0.0], 0.0) <= 0.0));
    let mut room = Room::new(Vec::new(), vec![disc(0.5, vec![[0.0, 0.2, 0.0]])], true);
    assert!(room.step(0.0).age.is_infinite());
}
