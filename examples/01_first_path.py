"""A map in, a path out: the exact shortest path of a robot through a small hall."""

import numpy as np

import guideway as gw

HALL = """
........................
.####..........#######..
.####..####....#######..
.......####.............
.......####...###..####.
..##..........###..####.
..##....####..###.......
........####............
"""

blocked = np.array([[c == "#" for c in row] for row in HALL.split()])
world = gw.World(blocked, resolution=0.5)  # row 0 on top, cells of 0.5 m
query = gw.Query(world, start=(0.5, 0.5), goal=(11.5, 3.6), footprint=gw.Disc(0.2))
solution = gw.plan(query)

print(solution)
print(solution.path.control_points.round(3))
assert solution.cost < 12.5
