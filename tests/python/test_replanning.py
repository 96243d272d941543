"""Replanning from Python: the colonies repair their way with the pheromone they kept."""

import numpy as np

import guideway as gw


def query(blocked, start, goal):
    return gw.Query(gw.World(blocked, resolution=1.0), start=start, goal=goal)


def test_a_blocked_way_is_repaired():
    blocked = np.zeros((20, 20), bool)
    first = gw.plan(query(blocked, (0.5, 0.5), (19.5, 19.5)), "bidirectional-aco", seed=1)
    blocked[5:15, 10] = True
    changed = query(blocked, (2.5, 2.5), (19.5, 19.5))
    again = gw.plan(changed, "bidirectional-aco", seed=1, previous=first)
    exact = gw.plan(changed, "jump-point")
    assert exact.cost <= again.cost <= 1.02 * exact.cost
    assert again.evaluations <= 400 < first.evaluations


def test_planners_without_memory_plan_anew():
    asked = query(np.zeros((5, 5), bool), (0.5, 0.5), (4.5, 4.5))
    first = gw.plan(asked)
    assert gw.plan(asked, previous=first).cost == first.cost
