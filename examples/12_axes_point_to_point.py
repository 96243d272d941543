"""Three axes from here to there: together, on a straight line, each for itself; from a motion under way, and to a speed instead of a place."""

import numpy as np

import guideway as gw

limits = {"velocity": [1.0, 2.0, 1.0], "acceleration": [2.0, 4.0, 1.5], "jerk": [20.0, 20.0, 8.0], "min_acceleration": [-3.0, -4.0, -1.5]}
start, goal = [0.0, 0.5, -1.0], [1.0, -0.7, -0.8]
for sync in ("none", "time", "phase"):
    motion = gw.point_to_point(start, goal, limits=limits, sync=sync)
    print(f"{sync:<5} {motion.duration:.4f} s, axes {np.round(motion.durations, 4)}, straight: {motion.straight}")

# The goal moves while the axes do: plan again from the state they are in. Durations are whole cycles of the controller.
under_way = motion.at(0.4)
again = gw.point_to_point(
    under_way["q"],
    [0.2, 0.6, -0.9],
    start_velocity=under_way["qd"],
    start_acceleration=under_way["qdd"],
    limits=limits,
    cycle=0.004,
)
cycles = again.duration / 0.004
print(f"again {again.duration:.4f} s, {cycles:.0f} cycles; the second axis has {len(again.phases[1])} pieces of constant jerk")
rows = again.sample(250.0)  # t, q, qd, qdd, qddd

# The first axis is to follow a conveyor at 0.3 /s, wherever it gets to; the others stop.
follow = gw.point_to_point(
    under_way["q"],
    None,
    start_velocity=under_way["qd"],
    start_acceleration=under_way["qdd"],
    goal_velocity=[0.3, 0.0, 0.0],
    limits=limits,
)
print(f"conveyor reached in {follow.duration:.4f} s at {follow.at(follow.duration)['q'][0]:.3f}")

assert np.allclose(rows["q"][-1], [0.2, 0.6, -0.9], atol=1e-12)
assert abs(cycles - round(cycles)) < 1e-9
assert np.all(np.abs(rows["qd"]) <= np.array(limits["velocity"]) + 1e-9)
