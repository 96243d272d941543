"""When there is no way: the proof, the widest robot that would pass, and where it is narrowest."""

import guideway as gw

walls = [
    {"polygon": {"points": [[2.0, 0.0], [2.2, 0.0], [2.2, 1.4], [2.0, 1.4]]}},
    {"polygon": {"points": [[2.0, 2.0], [2.2, 2.0], [2.2, 4.0], [2.0, 4.0]]}},
]
world = gw.World(bounds=[0, 0, 4, 4], shapes=walls, resolution=0.02)
query = gw.Query(world, start=(0.5, 0.5), goal=(3.5, 3.5), footprint=gw.Disc(0.35))
try:
    gw.plan(query)
except gw.NoPath as error:
    print(error)
    assert error.proved
    assert abs(error.widest - 0.3) < 0.01
