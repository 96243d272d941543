"""Smoothing keeps the curvature limit at every corner where an arc of that radius has room, recomputed here from the way points and the map alone."""

from __future__ import annotations

import math
from itertools import pairwise

import numpy as np
import pytest

import guideway as gw

LIMIT = 0.28
"""1/m"""


def arc(corner, into, turn):
    """Points of the arc of radius ``1 / LIMIT`` that is tangent to both legs of a corner."""
    radius = 1 / LIMIT
    side = math.copysign(1.0, turn)
    begin = corner - radius * math.tan(abs(turn) / 2) * into
    center = begin + side * radius * np.array([-into[1], into[0]])
    angles = math.atan2(*(begin - center)[::-1]) + turn * np.linspace(0, 1, 200)
    return center + radius * np.stack([np.cos(angles), np.sin(angles)], axis=1)


def corners(points, query):
    """Each corner of a polyline (m), its turn (rad), and whether the arc has room: its tangents on both legs, itself on the map."""
    legs = np.diff(points, axis=0)
    lengths = np.hypot(*legs.T)
    along = legs / lengths[:, None]
    turns = [math.atan2(u[0] * w[1] - u[1] * w[0], u @ w) for u, w in pairwise(along)]
    tangents = [0.0, *(math.tan(abs(turn) / 2) / LIMIT for turn in turns), 0.0]
    found = []
    for i, turn in enumerate(turns):
        # Legs that two corners share have room for both tangents.
        fits = tangents[i] + tangents[i + 1] <= lengths[i] and tangents[i + 1] + tangents[i + 2] <= lengths[i + 1]
        way = arc(points[i + 1], along[i], turn) if fits else []
        free = fits and all(query.world.segment_free(tuple(a), tuple(b), query.radius) for a, b in pairwise(way))
        found.append((points[i + 1], turn, free))
    return found


def judge(query, path):
    """All corners of the shortened path, and the largest curvature (1/m) of the smooth one near each."""
    found = corners(np.asarray(gw.refine(path, query, "simplify").path.control_points), query)
    smooth = gw.refine(path, query, "smooth", max_curvature=LIMIT).path
    places = smooth.planar(np.linspace(0, smooth.length, 20_001))
    if not found:
        return [], np.abs(places[:, 3]).max()
    nearest = np.argmin([np.hypot(*(places[:, :2] - at).T) for at, _, _ in found], axis=0)
    peaks = [np.abs(places[nearest == i, 3]).max(initial=0.0) for i in range(len(found))]
    return [(*corner, peak) for corner, peak in zip(found, peaks, strict=True)], max(peaks)


def violations(judged):
    return [(at.tolist(), round(math.degrees(turn), 1), peak) for at, turn, free, peak in judged if free and peak > LIMIT * (1 + 1e-6)]


@pytest.mark.parametrize("name", ["m20", "m30"])
def test_on_the_stand_ins_no_corner_has_room_and_the_bends_are_as_wide_as_their_legs(name):
    query = gw.scenes.load(name).query()
    for seed in range(30):
        judged, _ = judge(query, gw.plan(query, planner="improved-aco", seed=seed, set={"seeding": "off"}).path)
        assert not violations(judged), f"{name}, seed {seed}: {violations(judged)}"
        for at, turn, free, peak in judged:
            # Every corner has a leg of one cell and its arc would need 1.479 m of it: 0.44 1/m alone on that leg, 0.88 1/m beside another one.
            assert not free
            assert abs(abs(turn) - math.pi / 4) < 1e-9
            ends = min(np.abs(at - end).max() for end in (query.start, query.goal)) < 1.1
            assert peak < (0.46 if ends else 0.9), f"{name}, seed {seed}: {peak} 1/m at {at}"


@pytest.mark.parametrize("kind", ["simple", "cluttered"])
def test_wherever_the_arc_has_room_the_limit_is_kept(kind):
    judged = []
    for seed in range(20):
        query = gw.scenes.environment(kind, seed=seed).query()
        found, _ = judge(query, gw.plan(query, "jump-point").path)
        assert not violations(found), f"{kind}, seed {seed}: {violations(found)}"
        judged += found
    possible = sum(free for _, _, free, _ in judged)
    assert 20 <= possible < len(judged), "the maps tell nothing"
