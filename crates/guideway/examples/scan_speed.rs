//! Times of one scan and of one look at it: 360 discs and 20 movers. `cargo run --release --example scan_speed`

use guideway::drive::{Eyes, Lidar, Observation, Outline};
use guideway::world::{Footprint, Shape, World};
use std::sync::Arc;
use std::time::Instant;

fn main() -> Result<(), guideway::error::PlanError> {
    // Golden-angle spirals: discs all around, none on the robot.
    let place = |i: u32, from: f64| {
        let (r, a) = (from + 0.45 * f64::from(i).sqrt(), 2.4 * f64::from(i));
        [r * a.cos(), r * a.sin()]
    };
    let discs = (0..360).map(|i| Shape::disc(place(i, 2.0), 0.075)).collect::<Result<Vec<_>, _>>()?;
    let world = Arc::new(World::from_shapes([-12.0, -12.0, 12.0, 12.0], discs, 0.05)?);
    for (beams, map_known) in [(720, true), (720, false), (360, true), (360, false)] {
        let lidar = Lidar { beams, ..Lidar::default() };
        let (mut rng, mut eyes) = (Lidar::random(1), Eyes::new(lidar, &world, map_known)?);
        let (mut scans, mut looks) = (Vec::new(), Vec::new());
        let mut tracks = 0;
        for step in 0..2000 {
            let t = 0.05 * f64::from(step);
            let pose = [0.3 * t.cos(), 0.3 * t.sin(), t + std::f64::consts::FRAC_PI_2];
            let movers: Vec<_> = (0..20)
                .map(|i| {
                    let p = place(i + 1, 1.0);
                    (Outline::of(&Footprint::Disc(0.2)), [p[0] + 0.5 * (t + f64::from(i)).sin(), p[1] + 0.5 * (t + f64::from(i)).cos()])
                })
                .collect();
            let begun = Instant::now();
            let scan = lidar.scan(&world, &movers, (pose, t), &mut rng);
            scans.push(begun.elapsed().as_secs_f64());
            let mut seen = Observation::new(t, pose, 0.3, 1.0);
            let begun = Instant::now();
            eyes.look(&mut seen, Some(scan));
            looks.push(begun.elapsed().as_secs_f64());
            tracks = tracks.max(seen.tracks.len());
        }
        let show = |all: &mut Vec<f64>| {
            all.sort_by(f64::total_cmp);
            format!("median {:.3} ms, 99 % {:.3} ms", 1e3 * all[all.len() / 2], 1e3 * all[all.len() * 99 / 100])
        };
        println!("{beams} beams, map known {map_known}: scan {}; look {} ({tracks} tracks)", show(&mut scans), show(&mut looks));
    }
    Ok(())
}
