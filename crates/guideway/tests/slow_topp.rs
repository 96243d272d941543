//! A thousand random splines: none fails, the limits hold on a denser check, and little time is lost.
#![cfg(feature = "slow")]

use guideway::path::Path;
use guideway::timing::topp::{Demands, JointLimits, PerJoint, TopOptions, time_joints};
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;

#[test]
fn a_thousand_random_splines() {
    let limits = JointLimits {
        speed: Some(PerJoint::All(180f64.to_radians())),
        acceleration: Some(PerJoint::All(800f64.to_radians())),
        jerk: Some(PerJoint::All(1e4f64.to_radians())),
        ..JointLimits::default()
    };
    let mut rng = ChaCha8Rng::seed_from_u64(6);
    for case in 0..1000 {
        let (points, joints) = (rng.random_range(2..16usize), rng.random_range(1..8usize));
        let values: Vec<f64> = (0..points * joints).map(|_| rng.random_range(-1.5..1.5)).collect();
        let path = Path::through(&values, joints).unwrap();
        let motion = time_joints(&path, &limits, &TopOptions::default(), &mut Demands::default()).unwrap();
        assert!(motion.report.excess <= 1e-6, "{case}: {:?}", motion.report);
        if case % 20 == 0 {
            let fine = TopOptions { grid: Some(20_000), check: 2, tighten: false, ..TopOptions::default() };
            let limit = time_joints(&path, &limits, &fine, &mut Demands::default()).unwrap().duration();
            assert!(motion.duration() <= 1.001 * limit, "{case}: {} {limit}", motion.duration());
        }
        // Little more than the ramps of the acceleration, 0.08 s, per stop and per turn in which the path all but stops.
        let smooth = time_joints(&path, &limits, &TopOptions { jerk: true, ..TopOptions::default() }, &mut Demands::default()).unwrap();
        assert!(smooth.report.excess <= 1e-6, "{case}: {:?}", smooth.report);
        let stops = motion.x.iter().filter(|x| **x == 0.0).count() - 1;
        let price = smooth.duration() - motion.duration();
        assert!(price > 0.0 && price <= 0.1 * stops as f64 + 0.06 * motion.duration(), "{case}: {} {price}", motion.duration());
    }
}
