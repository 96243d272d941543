"""Exact searches on small grids in plain Python, for tests: no code in common with the package.

Cells are (x, y) from 1, (1, 1) at the lower left, as in the sources; ``blocked`` is a set of cells.
"""

import heapq
import math
from collections import defaultdict

STEPS = [(1, 0), (1, 1), (0, 1), (-1, 1), (-1, 0), (-1, -1), (0, -1), (1, -1)]


def read(text):
    """Side and blocked cells of a square text map, top row first."""
    rows = text.split()
    assert {len(row) for row in rows} == {len(rows)}
    n = len(rows)
    return n, {(x + 1, n - y) for y, row in enumerate(rows) for x, c in enumerate(row) if c == "#"}


def moves(n, blocked, cell, rule):
    """Legal steps from a cell: heading, next cell."""
    x, y = cell
    for heading, (dx, dy) in enumerate(STEPS):
        to = (x + dx, y + dy)
        if not (1 <= to[0] <= n and 1 <= to[1] <= n) or to in blocked:
            continue
        sides = [(x + dx, y) in blocked, (x, y + dy) in blocked]
        if dx and dy and (all(sides) if rule == "touch" else any(sides)):
            continue
        yield heading, to


def length(pair):
    return pair[0] * math.sqrt(2) + pair[1]


def optimum(n, blocked, rule, start=(1, 1), goal=None):
    """Least ((diagonals, straights), turns), ordered by length, then turns: Dijkstra on (cell, heading); None without a path."""
    goal = goal or (n, n)
    if start in blocked or goal in blocked:
        return None
    heap, done = [(0.0, 0, (0, 0), start, None)], set()
    while heap:
        _, turns, pair, cell, heading = heapq.heappop(heap)
        if (cell, heading) in done:
            continue
        done.add((cell, heading))
        if cell == goal:
            return pair, turns
        for way, to in moves(n, blocked, cell, rule):
            after = (pair[0] + way % 2, pair[1] + 1 - way % 2)
            heapq.heappush(heap, (length(after), turns + (heading is not None and way != heading), after, to, way))
    return None


def distances(n, blocked, rule, source):
    """Length as (diagonals, straights) of a shortest path from ``source`` to every cell reached."""
    heap, done = [(0.0, (0, 0), source)], {}
    while heap:
        _, pair, cell = heapq.heappop(heap)
        if cell in done:
            continue
        done[cell] = pair
        for way, to in moves(n, blocked, cell, rule):
            after = (pair[0] + way % 2, pair[1] + 1 - way % 2)
            heapq.heappush(heap, (length(after), after, to))
    return done


def counts(n, blocked, rule, start=(1, 1), goal=None):
    """How many shortest paths have how many turns: {turns: paths}, by adding up along the shortest steps."""
    goal = goal or (n, n)
    ahead = distances(n, blocked, rule, goal)
    paths = {start: {(None, 0): 1}}
    for cell in sorted(ahead, key=lambda c: -length(ahead[c])):
        for way, to in moves(n, blocked, cell, rule):
            step = (ahead[to][0] + way % 2, ahead[to][1] + 1 - way % 2)
            if cell not in paths or abs(length(step) - length(ahead[cell])) > 1e-9:
                continue
            into = paths.setdefault(to, defaultdict(int))
            for (heading, turns), many in paths[cell].items():
                into[way, turns + (heading is not None and way != heading)] += many
    found = defaultdict(int)
    for (_, turns), many in paths[goal].items():
        found[turns] += many
    return dict(found)


def sees(blocked, a, b):
    """Is the segment from ``a`` to ``b`` free? Points in doubled whole coordinates, where cell (x, y) covers 2x - 1 to 2x + 1.

    It may touch blocked cells, but not enter one, not pass between two that meet at a corner, and not run between two that lie side by side.
    """
    (ax, ay), (bx, by) = a, b
    dx, dy = bx - ax, by - ay
    low, high = (min(ax, bx), min(ay, by)), (max(ax, bx), max(ay, by))
    for x in range(low[0] // 2, high[0] // 2 + 2):
        for y in range(low[1] // 2, high[1] // 2 + 2):
            if (x, y) in blocked:
                sides = [dx * (2 * y + j - ay) - dy * (2 * x + i - ax) for i in (-1, 1) for j in (-1, 1)]
                beside = low[0] >= 2 * x + 1 or high[0] <= 2 * x - 1 or low[1] >= 2 * y + 1 or high[1] <= 2 * y - 1
                if not beside and min(sides) < 0 < max(sides):
                    return False
            cx, cy = 2 * x + 1, 2 * y + 1  # the upper right corner of the cell
            within = low[0] <= cx <= high[0] and low[1] <= cy <= high[1] and dx * (cy - ay) == dy * (cx - ax)
            if within and (cx, cy) not in (a, b):
                sw, se, nw, ne = ((x + i, y + j) in blocked for j in (0, 1) for i in (0, 1))
                if (sw and ne) or (se and nw):
                    return False
    along = [((ax - 1) // 2, y, (ax + 1) // 2, y) for y in range((low[1] + 1) // 2, high[1] // 2 + 1)] if dx == 0 and ax % 2 else []
    along += [(x, (ay - 1) // 2, x, (ay + 1) // 2) for x in range((low[0] + 1) // 2, high[0] // 2 + 1)] if dy == 0 and ay % 2 else []
    return not any((x, y) in blocked and (u, v) in blocked for x, y, u, v in along)


def any_angle(blocked, points, start, goal):
    """Length, in cells, of the shortest way from ``start`` to ``goal`` by straight lines between ``points``, all in doubled coordinates."""
    heap, done, points = [(0.0, 0.0, start)], set(), set(points) | {goal}
    while heap:
        _, far, point = heapq.heappop(heap)
        if point == goal:
            return far
        if point in done:
            continue
        done.add(point)
        for to in points - done:
            if sees(blocked, point, to):
                reached = far + math.dist(point, to) / 2
                heapq.heappush(heap, (reached + math.dist(to, goal) / 2, reached, to))  # never less than the straight line is left
    return None


def centres(n, blocked):
    """Centres of the free cells, in doubled coordinates."""
    return [(2 * x, 2 * y) for x in range(1, n + 1) for y in range(1, n + 1) if (x, y) not in blocked]


def corners(n, blocked):
    """Corners of blocked cells around which a shortest way may turn, in doubled coordinates: those where one of four cells is blocked."""
    around = [(i, j) for i in (0, 1) for j in (0, 1)]
    inner = ((x, y) for x in range(1, n) for y in range(1, n))
    return [(2 * x + 1, 2 * y + 1) for x, y in inner if sum((x + i, y + j) in blocked for i, j in around) == 1]
