"""Shortest paths among discs by the graph of all tangents and arcs: an oracle in plain Python that shares no code with the package."""

import heapq
import itertools
import math


def shortest(start, goal, discs, clearance, bounds=(-math.inf, -math.inf, math.inf, math.inf)):
    """Length of the shortest path from ``start`` to ``goal`` that keeps ``clearance`` from discs (x, y, r); None where there is none.

    Tangents and arcs that leave ``bounds`` are left out. That is the optimum where it is the same without bounds, else an upper bound of it: a
    path along a wall is not in the graph.
    """
    discs = [(x, y, r + clearance) for x, y, r in discs] + [(*start, 0.0), (*goal, 0.0)]
    begin, end = len(discs) - 2, len(discs) - 1
    edges, touched = {}, {i: set() for i in range(len(discs))}
    for i, j in itertools.combinations(range(len(discs)), 2):
        for a, b in tangents(discs[i], discs[j]):
            p, q = on(discs[i], a), on(discs[j], b)
            if (
                inside(bounds, p)
                and inside(bounds, q)
                and all(distance(p, q, (x, y)) >= r - 1e-9 for k, (x, y, r) in enumerate(discs) if k not in (i, j))
            ):
                u, v = (i, a % math.tau if discs[i][2] else 0.0), (j, b % math.tau if discs[j][2] else 0.0)
                edges.setdefault(u, []).append((v, math.dist(p, q)))
                edges.setdefault(v, []).append((u, math.dist(p, q)))
                touched[i].add(u)
                touched[j].add(v)
    for i, nodes in touched.items():
        around = sorted(nodes, key=lambda node: node[1])
        for u, v in itertools.pairwise([*around, *around[:1]]):
            turn = (v[1] - u[1]) % math.tau
            if u != v and free_arc(discs, i, u[1], turn, bounds):
                edges[u].append((v, discs[i][2] * turn))
                edges[v].append((u, discs[i][2] * turn))
    return dijkstra(edges, (begin, 0.0), (end, 0.0))


def on(disc, angle):
    return disc[0] + disc[2] * math.cos(angle), disc[1] + disc[2] * math.sin(angle)


def tangents(a, b):
    """Pairs of angles at which a line touches both discs."""
    d, way = math.dist(a[:2], b[:2]), math.atan2(b[1] - a[1], b[0] - a[0])
    if d > abs(a[2] - b[2]):
        half = math.acos((a[2] - b[2]) / d)
        yield from ((way + s * half, way + s * half) for s in (1, -1))
    if d > a[2] + b[2] and min(a[2], b[2]) > 0:
        half = math.acos((a[2] + b[2]) / d)
        yield from ((way + s * half, way + s * half + math.pi) for s in (1, -1))


def distance(a, b, p):
    square = math.dist(a, b) ** 2
    t = 0 if square == 0 else max(0, min(1, ((p[0] - a[0]) * (b[0] - a[0]) + (p[1] - a[1]) * (b[1] - a[1])) / square))
    return math.dist(p, (a[0] + t * (b[0] - a[0]), a[1] + t * (b[1] - a[1])))


def inside(bounds, p):
    return bounds[0] - 1e-9 <= p[0] <= bounds[2] + 1e-9 and bounds[1] - 1e-9 <= p[1] <= bounds[3] + 1e-9


def free_arc(discs, i, angle, turn, bounds):
    """Does no other disc reach into the arc? Finely sampled: gaps between discs are far wider than the step."""
    steps = max(2, math.ceil(turn / 1e-3))
    points = [on(discs[i], angle + turn * k / steps) for k in range(steps + 1)]
    return all(inside(bounds, p) for p in points) and all(math.dist(p, d[:2]) >= d[2] - 1e-6 for p in points for k, d in enumerate(discs) if k != i)


def dijkstra(edges, start, goal):
    best, heap = {start: 0.0}, [(0.0, start)]
    while heap:
        cost, node = heapq.heappop(heap)
        if node == goal:
            return cost
        for to, length in edges.get(node, ()):
            if cost + length < best.get(to, math.inf):
                best[to] = cost + length
                heapq.heappush(heap, (cost + length, to))
    return None
