"""Your own planner against ours, on your maps: any object with ``plan(query)`` that returns points. Each path is checked, each run is a record."""

import tempfile
from collections import deque

import guideway as gw


class FourWays:
    """Breadth-first search over four neighbours: short to write, long to drive."""

    def plan(self, query):
        free = query.world.occupancy() == 0
        start, goal = ((len(free) - 1 - int(y), int(x)) for x, y in (query.start, query.goal))
        before, todo = {goal: goal}, deque([goal])
        while todo and start not in before:
            row, column = todo.popleft()
            for near in ((row + 1, column), (row - 1, column), (row, column + 1), (row, column - 1)):
                if 0 <= near[0] < len(free) and 0 <= near[1] < len(free) and free[near] and near not in before:
                    before[near] = (row, column)
                    todo.append(near)
        way = [start]
        while way[-1] != goal:
            way.append(before[way[-1]])
        return query.world.cell_centers([(column, row) for row, column in way])


if __name__ == "__main__":
    maps = [gw.scenes.complexity(20, 0.1, seed=1), gw.scenes.environment("maze", seed=2), "scene:pso-aco-1"]
    planners = {"mine": FourWays(), "astar": "astar", "improved-aco": "improved-aco"}
    with tempfile.TemporaryDirectory() as folder:
        found = gw.lab.compare(planners, maps, seeds=3, budget=gw.Budget(evaluations=500), out=folder)
        print(found)
    assert {record["status"] for record in found.records} == {"ok"}
