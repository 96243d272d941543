//! The guarantee of the default controller: no collision while moving, whatever movers do within their speed bounds.

mod guarded;

#[test]
fn no_collision_while_moving_in_20_000_random_steps() {
    let (mut all, mut seed) = (guarded::Tally::default(), 0);
    while all.steps < 20_000 {
        all = all.add(guarded::drive(seed));
        seed += 1;
    }
    assert_eq!(all.moving, 0, "{:?}", all.first);
    assert!(all.metres > 100.0, "the robot hardly moved: {all:?}");
    println!("{all:?}");
}
