"""Every planner on one query: lattice planners pay for their eight directions, the exact one shows how much."""

import numpy as np

import guideway as gw

rng = np.random.default_rng(1)
blocked = rng.random((60, 80)) < 0.2
blocked[:3, :] = blocked[-3:, :] = False
world = gw.World(blocked, resolution=0.1)
query = gw.Query(world, start=(0.05, 0.05), goal=(7.95, 5.95), corners="clear")

exact = gw.plan(query, "visibility").cost
for entry in gw.planners():
    solution = gw.plan(query, entry["name"])
    gap = solution.length / exact - 1
    print(f"{entry['name']:<17} {solution.length:8.4f} m  {100 * gap:5.2f} % above the optimum  {1e3 * solution.seconds:8.3f} ms")
    assert gap >= -1e-9
