"""One query, three products by material: the shortest path, the safest for long loads, the one of least energy for heavy loads."""

import guideway as gw
from guideway import jobs, products

world = gw.World.load("scene:warehouse")  # ships with the package
limits = gw.Limits(speed=1.5, acceleration=0.8, deceleration=1.0, jerk=3.0, turn_rate=1.5, turn_acceleration=3.0, lateral_acceleration=0.8)
job = jobs.Job(
    world, start=(-5.4, -19.0), goal=(9.5, 21.5), footprint=gw.Disc(0.35).to_dict(), clearance=0.15, half_width=0.8, material="heavy", limits=limits
)
plan = products.compare(job, ".", own=True).record

print("\n".join(products.table(plan["products"])))
chosen = next(row for row in plan["candidates"] if row["chosen"])
print(f"least energy of {len(plan['candidates'])} candidates: {chosen['refine']}, planned with {chosen['room']} m more room")
gw.view.report([plan], "products.html", worlds=[world], title="Three products of one query")

energy = {name: product["metrics"]["drive_energy"] for name, product in plan["products"].items()}
assert energy["heavy"] == min(energy.values())
assert plan["products"]["long"]["metrics"]["min_clearance"] > 0.4
