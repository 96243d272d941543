"""The certificate of a timed motion: every limit checked on the motion itself, by direct inverse dynamics, finer than the solver's points."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np

from guideway.arm.model import direction
from guideway.arm.motion import ArmMotion
from guideway.arm.rows import tip_derivatives

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from guideway.arm.collisions import Surroundings

    Floats = NDArray[np.float64]

TOLERANCE = 1e-6
"""Excess over a limit that counts as rounding, relative to the limit."""

WITHIN = 6
"""Samples within each piece of constant jerk, both of its ends included."""

TURNING = 1e-6
"""Share of the path below which a joint may be turning round at the end of a piece."""


def certify(
    motion: ArmMotion,
    *,
    collisions: bool = True,
    surroundings: Surroundings | None = None,
    clearance: float | None = None,
    tolerance: float = TOLERANCE,
    within: int = WITHIN,
) -> dict[str, Any]:
    """Checks a motion: its pieces follow each other, limits of joints and tip hold at ``within`` samples of every piece, joint ranges are kept,
    and with ``collisions`` the arm keeps clear of itself and of ``surroundings`` (default: itself alone), proved between samples too.

    Returns ``ok`` and ``checks``, each with ``name``, ``ok``, the largest ``ratio`` to its limit, the ``joint``, ``t`` (s) and ``s`` (rad) of it;
    ``collision`` as of :func:`guideway.arm.collisions.check`, None where it was not checked.
    """
    state = within_pieces(motion, within)
    checks = [_continuous(motion), *_ratios(motion, state, tolerance)]
    if motion.arm is not None:
        checks.append(_range(motion, state))
    collision = None
    if collisions and motion.arm is not None and len(motion.pieces):
        from guideway.arm import collisions as module

        around = surroundings or module.Surroundings(motion.arm)
        collision = module.check(around, motion.path.path, clearance, end=float(state["s"].max()))
    ok = all(check["ok"] for check in checks) and (collision is None or collision["ok"])
    return {"ok": ok, "samples": len(state["t"]), "tolerance": tolerance, "checks": checks, "collision": collision}


def within_pieces(motion: ArmMotion, count: int) -> dict[str, Floats]:
    """States at ``count`` places of every piece, each from the piece's own side: accelerations may step between pieces."""
    share = np.linspace(0.0, 1.0, count)
    t0, s0, v0, a0, j0, length = (np.repeat(column, count) for column in motion.pieces.T)
    d = np.tile(share, len(motion.pieces)) * length
    s = np.clip(s0 + d * (v0 + d * (a0 / 2 + d * j0 / 6)), 0.0, motion.path.path.length)
    v, a = v0 + d * (a0 + d * j0 / 2), a0 + d * j0
    q, one, two, three = motion.path.path.eval(s, 3)
    vv, aa, jj = v[:, None], a[:, None], j0[:, None]
    qd, qdd = one * vv, one * aa + two * vv**2
    qddd = one * jj + 3 * two * vv * aa + three * vv**3
    state = {"t": t0 + d, "s": s, "speed": v, "acceleration": a, "first": one, "q": q, "qd": qd, "qdd": qdd, "qddd": qddd}
    return state | {"direction": _directions(one, count)}


def _directions(first: Floats, count: int) -> Floats:
    """Which way each joint moves at the samples of the pieces; at the ends of a piece, where a joint may turn round, as within it."""
    found = direction(first).reshape(-1, count, first.shape[1])
    if count > 2:
        share = np.abs(first).reshape(found.shape)
        for end, inside in ((0, 1), (count - 1, count - 2)):
            found[:, end] = np.where(share[:, end] < TURNING, found[:, inside], found[:, end])
    return found.reshape(first.shape)


def _check(name: str, ratios: Floats, state: dict[str, Floats], names: tuple[str, ...] | None, tolerance: float) -> dict[str, Any]:
    """The record of a limit from the shares of it that are used, (n, joints) or (n,)."""
    worst = np.unravel_index(int(np.argmax(ratios)), ratios.shape)
    ratio = float(ratios[worst])
    joint = names[worst[1]] if names is not None and ratios.ndim == 2 else None
    moment = int(worst[0])
    return {
        "name": name if joint is None else f"{name} of {joint}",
        "limit": name,
        "ok": ratio <= 1 + tolerance,
        "ratio": ratio,
        "joint": joint,
        "t": float(state["t"][moment]),
        "s": float(state["s"][moment]),
    }


def _ratios(motion: ArmMotion, state: dict[str, Floats], tolerance: float) -> list[dict[str, Any]]:
    limits, names, found = motion.limits, motion.names, list[dict[str, Any]]()
    count = len(names)

    def per_joint(name: str) -> Floats | None:
        return limits.per_joint(name, count)

    def add(name: str, ratios: Floats) -> None:
        found.append(_check(name, ratios, state, names, tolerance))

    if not len(motion.pieces):
        return found
    if (speed := per_joint("speed")) is not None:
        add("speed", np.abs(state["qd"]) / speed)
    along = state["qdd"] * np.where(state["first"] >= 0, 1.0, -1.0)
    faster, slower = per_joint("acceleration"), per_joint("deceleration")
    slower = faster if slower is None else slower
    if faster is not None:
        add("acceleration", along / faster)
    if slower is not None:
        add("deceleration", -along / slower)
    smooth = "brake" not in motion.report and motion.report.get("jerk", True)
    if smooth and (jerk := per_joint("jerk")) is not None:
        add("jerk", np.abs(state["qddd"]) / jerk)
    torque, rate = per_joint("torque"), per_joint("torque_rate") if smooth else None
    if motion.arm is not None and (torque is not None or rate is not None):
        asked = motion.torques(state)
        if torque is not None:
            add("torque", np.abs(asked) / torque)
        if rate is not None:
            add("torque_rate", _rates(motion, asked, state) / rate)
    return found + _tip(motion, state, tolerance)


def _rates(motion: ArmMotion, asked: Floats, state: dict[str, Floats]) -> Floats:
    """Torque rates between neighbouring samples of one piece, N m/s; steps of Coulomb friction, where a joint turns round, do not count."""
    coulomb = motion.arm.friction.arrays(motion.arm.joints)[1] if motion.arm is not None else 0.0
    smooth = asked - coulomb * state["direction"]
    dt, change = np.diff(state["t"]), np.abs(np.diff(smooth, axis=0))
    rates = np.zeros_like(asked)
    inside = dt > 1e-9
    inside &= np.arange(1, len(state["t"])) % (len(state["t"]) // len(motion.pieces)) != 0
    rates[1:][inside] = change[inside] / dt[inside, None]
    return rates


def worst_rate(motion: ArmMotion, within: int = WITHIN) -> float:
    """The largest share of the limit of torque rate that a motion uses, 0 without such a limit."""
    rate = motion.limits.per_joint("torque_rate", len(motion.names))
    if rate is None or not len(motion.pieces):
        return 0.0
    state = within_pieces(motion, within)
    return float(np.max(_rates(motion, motion.torques(state), state) / rate))


def _tip(motion: ArmMotion, state: dict[str, Floats], tolerance: float) -> list[dict[str, Any]]:
    limits, arm, found = motion.limits, motion.arm, list[dict[str, Any]]()
    if arm is None or (limits.tip_speed is None and limits.tip_acceleration is None):
        return found
    first, second = tip_derivatives(arm, motion.path.path, state["s"])
    v, a = state["speed"][:, None], state["acceleration"][:, None]
    for name, limit, vector in (("tip_speed", limits.tip_speed, first * v), ("tip_acceleration", limits.tip_acceleration, first * a + second * v**2)):
        if limit is not None:
            found.append(_check(name, np.linalg.norm(vector, axis=1) / limit, state, None, tolerance))
    return found


def _range(motion: ArmMotion, state: dict[str, Floats]) -> dict[str, Any]:
    """Are all joints within their range? ``margin``: the distance to the nearest end of one, rad."""
    assert motion.arm is not None
    margins = np.minimum(state["q"] - motion.arm.lower, motion.arm.upper - state["q"])
    if not margins.size:
        return {"name": "joint range", "limit": "range", "ok": True, "margin": None}
    worst = np.unravel_index(int(np.argmin(margins)), margins.shape)
    moment = int(worst[0])
    margin = float(margins[worst])
    return {
        "name": f"range of {motion.names[worst[1]]}",
        "limit": "range",
        "ok": margin >= -1e-9,
        "margin": margin if np.isfinite(margin) else None,
        "joint": motion.names[worst[1]],
        "t": float(state["t"][moment]),
        "s": float(state["s"][moment]),
    }


def _continuous(motion: ArmMotion) -> dict[str, Any]:
    """Do the pieces follow each other in time, place and speed, forwards, from the start of the path to where the motion ends?"""
    rows = motion.pieces
    gap = 0.0
    if len(rows):
        t, s, v, a, j, d = rows.T
        end = np.stack([t + d, s + d * (v + d * (a / 2 + d * j / 6)), v + d * (a + d * j / 2)])
        steps = [np.abs(end[:, :-1] - rows[1:, :3].T).max(initial=0.0), abs(s[0]), max(0.0, -float(min(v.min(), end[2].min())))]
        whole = "brake" not in motion.report or motion.report["brake"]["factor"] > 0
        gap = max(*steps, abs(end[1, -1] - motion.path.path.length) if whole else 0.0)
    return {"name": "pieces follow each other", "limit": "continuity", "ok": bool(gap <= 1e-7), "gap": float(gap)}
