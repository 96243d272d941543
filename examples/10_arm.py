"""A robot arm from its description to a program: a tool path, time-optimal under torque limits, certified, as URScript and for ROS."""

from pathlib import Path

import guideway as gw

try:
    arm = gw.arm.robot("ur5e", payload=5.0, friction=gw.arm.Friction(coulomb=(7, 7, 7, 2, 2, 2)))  # or Arm.load("robot.urdf")
except ImportError as missing:
    print(missing)
    raise SystemExit(0) from None

seam = gw.arm.star()  # or gw.arm.load_nurbs("seam.toml")
arm = gw.arm.arm_for(arm, seam)
path = gw.arm.joint_path(arm, seam)
print(f"path: {path.path.length:.4f} rad of joints, {seam.length():.4f} m of the tool")
print(f"smallest singular value on the way: {path.report['smallest_singular_value']:.3f}")

limits = gw.arm.JointLimits(acceleration=10.0, torque=gw.arm.STAR_TORQUE)
kinematic = gw.arm.time(path, limits, arm, torque=False)
motion = gw.arm.time(path, limits, arm)
print(f"fastest without torque limits {kinematic.duration:.4f} s, with them {motion.duration:.4f} s")

table = {"kind": "box", "size": (1.0, 1.0, 0.05), "at": (0.0, -0.3, 0.02), "name": "table"}
around = gw.arm.Surroundings(arm, gw.arm.Scene((table,), clearance=0.005))
certificate = motion.certify(surroundings=around)
for check in certificate["checks"]:
    if "ratio" in check:
        print(f"  {check['name']:<32} {100 * check['ratio']:6.2f} % of its limit at {check['t']:.3f} s")
print(f"  closest: {certificate['collision']['closest']['pair']}, {certificate['collision']['closest']['distance']:.3f} m")
assert certificate["ok"]

stopped = motion.stop_from(0.8)
print(f"stopped at 0.8 s: at rest on the path after {stopped.duration - 0.8:.3f} s, {stopped.report['brake']['way']:.3f} rad")

Path("star.script").write_text(gw.arm.urscript(motion))
Path("star.yaml").write_text(gw.arm.ros_yaml(motion))
print("wrote star.script and star.yaml")
