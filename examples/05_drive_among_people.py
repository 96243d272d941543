"""Drive a planned motion through a corridor while two people cross it, and write the report."""

import tempfile
from pathlib import Path

import guideway as gw

people = [
    {"shape": {"disc": 0.3}, "track": [[0, 4.0, 0.6], [4, 4.0, 3.4]], "loop": "shuttle", "phase": 0.0, "appears": None},
    {"shape": {"disc": 0.3}, "track": [[0, 8.0, 3.4], [5, 7.0, 0.6]], "loop": "shuttle", "phase": 1.0, "appears": None},
]
world = gw.World(bounds=[0, 0, 12, 4], shapes=[{"disc": {"center": [6.0, 2.0], "radius": 0.4}}], movers=people, resolution=0.05)
query = gw.Query(world, start=(1.0, 2.0), goal=(11.0, 2.0), footprint=gw.Disc(0.25), clearance=0.1)
limits = gw.Limits(speed=1.0, acceleration=1.0, jerk=4.0, turn_rate=2.0, turn_acceleration=4.0)
motion = gw.time(gw.refine(gw.plan(query).path, query).path, limits)
run = gw.drive(query, motion, seed=3)

print(f"{run['outcome']} after {run['time']:.1f} s (planned {motion.duration:.1f} s), {run['min_separation']} m apart, {len(run['events'])} events")
with tempfile.TemporaryDirectory() as folder:
    target = Path(folder) / "run.html"
    gw.view.report([run], target, worlds=[world])
    print(f"report of {target.stat().st_size // 1024} kB")
assert run["outcome"] == "arrived"
