"""Ants plan a way, a cell of it is shut, and they repair it with the pheromone they kept; a report shows both."""

import numpy as np

import guideway as gw
from guideway import jobs

world = gw.World.load("scene:m30")  # ships with the package
job = jobs.Job(world, start=(0.5, 0.5), goal=(29.5, 29.5), planner="pso-aco", seed=7, refine="none")
plan = jobs.run(job)
first = plan.solution

blocked = np.asarray(world.occupancy()) != 0
column, row = first.cells[len(first.cells) // 2].astype(int)  # row 0 on top, as in the image
blocked[row, column] = True
job.world = gw.World(blocked, resolution=world.resolution)
query = job.query()
again = gw.plan(query, "pso-aco", seed=7, previous=first)
anew = gw.plan(query, "pso-aco", seed=7)
exact = gw.plan(query, "jump-point")

for name, solution in (("first", first), ("repaired", again), ("planned anew", anew), ("exact", exact)):
    print(f"{name:<13} {solution.cost:8.4f} m  {solution.evaluations:>5} ways judged  {1e3 * solution.seconds:8.3f} ms")

(leg,) = plan.record["trace"]["legs"]
column, row, most = max(leg["pheromone"], key=lambda cell: cell[2])  # row 0 at the bottom
print(f"swarm: {leg['swarm_iterations']} iterations; strongest pheromone {most} out of cell {column}, {row}; {len(leg['pheromone'])} cells marked")

repaired = jobs.finish(job, query, again, ".").record
gw.view.report([plan.record, repaired | {"label": "repaired"}], "ants.html", worlds=[world, job.world], title="Ants, before and after")

assert exact.cost - 1e-9 <= again.cost <= 1.05 * exact.cost
assert again.evaluations < anew.evaluations
assert [int(v) for v in first.cells[len(first.cells) // 2]] not in again.cells.astype(int).tolist()
