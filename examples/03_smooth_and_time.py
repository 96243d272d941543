"""From a raw path to a motion: a B-spline that provably stays free, then time with limited jerk."""

import guideway as gw

shelf = {"polygon": {"points": [[3.0, 1.0], [4.0, 1.0], [4.0, 4.0], [3.0, 4.0]]}}
pillar = {"disc": {"center": [6.0, 2.2], "radius": 0.5}}
world = gw.World(bounds=[0, 0, 9, 5], shapes=[shelf, pillar], resolution=0.05)
query = gw.Query(world, start=(1.0, 2.5, 0.0), goal=(8.0, 2.0), footprint=gw.Disc(0.3), clearance=0.1)

solution = gw.plan(query)
refined = gw.refine(solution.path, query)
limits = gw.Limits(speed=1.2, acceleration=0.8, deceleration=1.0, jerk=3.0, turn_rate=1.5, lateral_acceleration=0.7)
motion = gw.time(refined.path, limits, start_yaw=query.start_yaw)
certificate = gw.certify(refined.path, query, motion)

print(f"raw {solution.cost:.3f} m, smooth {refined.path.length:.3f} m, {motion.duration:.2f} s, certificate {certificate['ok']}")
print("t, x, y, yaw, speed, acceleration, jerk, curvature")
print(motion.sample(2.0).round(3))
assert certificate["ok"]
