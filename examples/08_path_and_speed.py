"""Path and speed planned at once in a room with discs: by the closed loop, and by the shortest path with corrected speed; a report shows both."""

import guideway as gw
from guideway import jobs

world = gw.World.load("scene:w0")  # ships with the package
limits = gw.Limits(speed=2.0, acceleration=5.0, jerk=10.0, turn_rate=2.0, lateral_acceleration=2.0)
records = []
for planner in ("iascv", "aide"):
    job = jobs.Job(world, start=(0.0, 0.0), goal=(5.0, 3.0), clearance=0.3, footprint={"disc": 0.0}, limits=limits, planner=planner, seed=1)
    found = jobs.run(job)
    records.append(found.record)
    metrics = found.record["metrics"]
    print(f"{planner:<6} {metrics['length']:.3f} m in {found.trajectory.duration:.3f} s, curvature up to {metrics['max_curvature']:.2f} 1/m")

trace = records[-1]["trace"]
bound = trace["bound"]
print(f"objective {bound['value']:.4f}, at most {100 * bound['gap']:.1f} % above what is possible")
for number, each in enumerate(trace["classes"], 1):
    best = "no free curve" if each["best"] is None else f"best objective {each['best']:.4f}"
    print(f"  way {number} past the discs: shortest {each['length']:.3f} m, {best}{' <- taken' if each['chosen'] else ''}")
gw.view.report(records, "path_and_speed.html", worlds=world, title="Path and speed at once")

assert all(record["certificate"]["ok"] for record in records)
assert 0 < bound["lower"] <= bound["value"]
assert sum(each["chosen"] for each in trace["classes"]) == 1
