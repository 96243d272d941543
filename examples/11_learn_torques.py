"""An arm learns how fast it may be: it carries 5 kg that its controller does not know of, and only its measured torques tell."""

import guideway as gw

try:
    arm = gw.arm.robot("ur5e")
except ImportError as missing:
    print(missing)
    raise SystemExit(0) from None
path = gw.arm.joint_path(arm, gw.arm.star())
limits = gw.arm.JointLimits(acceleration=10.0, torque=gw.arm.STAR_TORQUE)


def tell(trial: gw.arm.Trial) -> None:
    above = 100 * (trial.duration / trial.lower_bound - 1) if trial.lower_bound else float("nan")
    used = 100 * (1 + trial.measured)
    print(f"trial {trial.number}: {trial.duration:.3f} s, at most {above:.1f} % above the optimum, torque {used:.1f} % of its limit")


found = gw.arm.learn(path, limits, arm, plant="ideal", simulated={"payload": 5.0, "noise": 0.5, "seed": 1}, trials=4, observe=tell)
assert found.oracle is not None
print(f"learned {found.motion.duration:.3f} s; with the true load known it would be {found.oracle.duration:.3f} s")
assert found.motion.duration < 1.05 * found.oracle.duration
