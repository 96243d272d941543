use super::super::testing::{curve, drive, drive_along, parked, query, room, shuttle};
use super::super::{Outcome, Run};
use crate::world::Mover;

const ROOM: [f64; 4] = [0.0, 0.0, 10.0, 6.0];
const BEND: [[f64; 2]; 3] = [[1.0, 1.0], [5.0, 1.0], [5.0, 4.0]];

fn bend(movers: Vec<Mover>, seed: u64) -> Run {
    let world = room(ROOM, Vec::new(), movers);
    drive("improved-dwa", &query(&world, &BEND), &BEND, seed, |_| {})
}

#[test]
fn a_free_path_is_followed_closely() {
    let control = [[1.0, 1.0], [2.5, 1.0], [4.5, 1.0], [6.0, 2.0], [6.0, 3.5], [6.0, 5.0]];
    let world = room(ROOM, Vec::new(), Vec::new());
    let motion = curve(&control);
    let run = drive_along("improved-dwa", &query(&world, &[control[0], control[5]]), (&motion, None), 0, |_| {});
    assert_eq!((run.outcome, run.emergency_stops), (Outcome::Arrived, 0), "{:?}", run.events);
    assert!(run.tracking.tte < 0.1 && run.tracking.tpe < 0.06 && run.time < 1.3 * motion.duration(), "{} {:?}", run.time, run.tracking);
}

#[test]
fn a_sharp_corner_is_taken() {
    let run = bend(Vec::new(), 0);
    assert_eq!(run.outcome, Outcome::Arrived, "{:?}", run.events);
}

#[test]
fn a_parked_mover_is_passed_without_a_new_plan() {
    let run = bend(vec![parked(0.3, [3.0, 1.0])], 0);
    assert_eq!((run.outcome, run.replans), (Outcome::Arrived, 0), "{:?}", run.events);
    assert!(run.min_separation.movers.unwrap() > 0.05);
}

#[test]
fn crossing_movers_are_let_through() {
    for seed in 0..8_u32 {
        let phase = f64::from(seed) * 1.7;
        let movers = vec![shuttle(0.3, [[3.0, 0.0], [3.0, 4.0]], 0.4, phase), shuttle(0.3, [[3.0, 2.5], [7.0, 2.5]], 0.4, 2.0 * phase)];
        let run = bend(movers, u64::from(seed));
        assert_eq!(run.outcome, Outcome::Arrived, "seed {seed} {:?}", run.events);
    }
}
