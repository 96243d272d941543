"""What an arm's record says about its motion, thinned for a picture: samples over time, the phase plane, stretches by active constraint."""

from __future__ import annotations

import re
from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

from .geometry import listed

Floats = NDArray[np.float64]

MOST_SAMPLES = 900
"""Samples over time of one motion."""
MOST_NUMBERS = 90_000
"""Numbers over time of all motions in a report."""
MOST_POINTS = 1000
"""Points of the phase plane of one motion."""
REACHED = 0.995
"""Share of a limit from which on it counts as reached."""


def course(record: Mapping[str, Any], among: int = 1) -> dict[str, Any]:
    """Samples over time: ``t`` (s), ``s`` (rad), ``v``, ``a`` of the path, ``q, qd, qdd, qddd`` (a list per joint), ``tau`` (N m) and whether it is
    ``measured``; ``jerky`` where the acceleration may step, so that jerk says nothing. From the pieces of the record where it has them, else
    read from its table."""
    joints = len(listed(record.get("joints")))
    count = max(60, min(MOST_SAMPLES, MOST_NUMBERS // max(1, 5 * joints * among)))
    found = _evaluated(record, count) or _read(record, count)
    jerk = record.get("limits", {}).get("jerk") if isinstance(record.get("limits"), Mapping) else None
    report = record.get("report")
    found["jerky"] = jerk is None or (isinstance(report, Mapping) and report.get("jerk") is False)
    tau, measured = (record.get("tau"), True) if listed(record.get("tau")) else (record.get("tau_model"), False)
    table, t = matrix(tau), vector(record.get("t"))
    if found["t"] and len(table) == len(t) and len(t) > 1:
        found["tau"] = [np.interp(found["t"], t, part).tolist() for part in table.T]
        found["measured"] = measured
    return found


def _evaluated(record: Mapping[str, Any], count: int) -> dict[str, Any] | None:
    """Samples of the motion itself."""
    from guideway.arm import load_motion
    from guideway.errors import GuidewayError

    try:
        motion = load_motion(dict(record))
        if not len(motion.pieces) or not 0 < motion.duration < np.inf:
            return None
        sample = motion.sample(times=np.linspace(0.0, motion.duration, count))
    except (GuidewayError, AttributeError, KeyError, TypeError, ValueError):
        return None
    found: dict[str, Any] = {
        "t": sample["t"].tolist(),
        "s": sample["s"].tolist(),
        "v": sample["speed"].tolist(),
        "a": sample["acceleration"].tolist(),
    }
    return found | {key: sample[key].T.tolist() for key in ("q", "qd", "qdd", "qddd")}


def _read(record: Mapping[str, Any], count: int) -> dict[str, Any]:
    """Samples of the record's own table."""
    t = vector(record.get("t"))
    kept = np.unique(np.linspace(0, max(len(t) - 1, 0), min(count, len(t))).round().astype(int)) if len(t) else np.zeros(0, int)
    found: dict[str, Any] = {"t": t[kept].tolist()}
    for key in ("q", "qd", "qdd"):
        table = matrix(record.get(key))
        if len(table) == len(t) and len(t):
            found[key] = table[kept].T.tolist()
    return found


def vector(value: Any) -> Floats:
    """A list of finite numbers as an array; empty where it is none."""
    try:
        found = np.asarray(listed(value), float)
    except (TypeError, ValueError):
        return np.zeros(0)
    return found if found.ndim == 1 and np.isfinite(found).all() else np.zeros(0)


def matrix(value: Any) -> Floats:
    """A list of rows of finite numbers as an array; empty where it is none."""
    try:
        found = np.asarray(listed(value), float)
    except (TypeError, ValueError):
        return np.zeros((0, 0))
    return found if found.ndim == 2 and np.isfinite(found).all() else np.zeros((0, 0))


def grid_of(record: Mapping[str, Any]) -> tuple[Floats, Floats, Floats, list[str | None]]:
    """Places, squared path speeds, maximum velocity curve (NaN: unlimited) and active constraints of the solver's points."""
    given = record.get("grid")
    grid = given if isinstance(given, Mapping) else {}
    s = vector(grid.get("s"))
    x, mvc = (holed(grid.get(key), len(s)) for key in ("x", "mvc"))
    names = [name if isinstance(name, str) and name else None for name in listed(grid.get("active"))]
    return s, x, mvc, names if len(names) == len(s) else [None] * len(s)


def holed(value: Any, count: int) -> Floats:
    """Numbers with holes, NaN throughout where there are not ``count`` of them."""
    try:
        found = np.array([np.nan if item is None else item for item in listed(value)], float)
    except (TypeError, ValueError):
        found = np.zeros(0)
    return found if found.shape == (count,) else np.full(count, np.nan)


def phase(record: Mapping[str, Any], samples: Mapping[str, Any]) -> dict[str, Any]:
    """The phase plane: ``s`` (rad), path speed ``v``, the curves that no motion exceeds: ``first``, of joint speeds alone, and ``second``, of all
    limits (rad/s; null: unlimited). ``kinematic`` where the second one is of joint speeds and accelerations only."""
    s, x, mvc, _ = grid_of(record)
    if len(s) < 2 or not np.isfinite(x).any():
        return {"s": list(samples.get("s") or []), "v": list(samples.get("v") or [])}
    step = max(1, -(-len(s) // MOST_POINTS))
    kept = np.unique([*range(0, len(s), step), len(s) - 1])
    first, other = _kinematic(record, s[kept])
    told = np.isfinite(mvc).any()
    second = mvc[kept] if told else other
    roots = {"v": x[kept], "first": first, "second": second}
    lists = {key: np.sqrt(np.maximum(value, 0.0)).tolist() for key, value in roots.items() if value is not None}
    return {"s": s[kept].tolist(), **lists, "kinematic": not told}


def _kinematic(record: Mapping[str, Any], s: Floats) -> tuple[Floats | None, Floats | None]:
    """Squared path speeds allowed by joint speeds, and by joint speeds and accelerations, at places ``s``; None where they are not known."""
    from guideway.arm import load_motion
    from guideway.errors import GuidewayError

    try:
        motion = load_motion(dict(record))
        limits, joints = motion.limits, len(motion.names)
        _, one, two = motion.path.path.eval(s, 2)
        speed, faster, slower = (limits.per_joint(name, joints) for name in ("speed", "acceleration", "deceleration"))
    except (GuidewayError, AttributeError, KeyError, TypeError, ValueError):
        return None, None
    first = None if speed is None else np.min((speed / np.maximum(np.abs(one), 1e-9)) ** 2, axis=1)
    if faster is None:
        return first, None
    second = highest(one, two, faster, faster if slower is None else slower)
    return first, second if first is None else np.minimum(first, second)


def highest(one: Floats, two: Floats, faster: Floats, slower: Floats) -> Floats:
    """Largest squared path speeds (n,) at which some path acceleration keeps all joint accelerations, from the path's derivatives (n, joints)."""
    still = np.abs(one) < 1e-9
    size = np.where(still, 1.0, np.abs(one))
    bend = np.where(one < 0, -two, two)
    high, low, slope = faster / size, -slower / size, bend / size
    # every lower bound -slower_i - bend_i x must stay below every upper bound faster_j - bend_j x
    steep = slope[:, None, :] - slope[:, :, None]
    room = high[:, None, :] - low[:, :, None]
    usable = ~still[:, None, :] & ~still[:, :, None] & (steep > 1e-12)
    pairs = np.where(usable, room / np.where(usable, steep, 1.0), np.inf).min(axis=(1, 2))
    alone = np.where(still & (np.abs(two) > 1e-12), np.minimum(faster, slower) / np.maximum(np.abs(two), 1e-12), np.inf).min(axis=1)
    return np.asarray(np.minimum(pairs, alone))


def stretches(record: Mapping[str, Any], samples: Mapping[str, Any]) -> list[dict[str, Any]]:
    """Stretches of the path with the same active constraint: ``from`` and ``to`` (rad), ``begins`` and ``ends`` (s), its ``name``, the ``kind`` of
    limit and the ``joint`` (number from 0), where it is that of a joint.

    Where several limits are reached at once the solver may name each in turn; a stretch goes on as long as its own limit is reached.
    """
    s, _, _, names = grid_of(record)
    if len(s) < 2 or not any(names):
        return []
    joints = [str(name) for name in listed(record.get("joints"))]
    t, at = np.asarray(samples.get("t") or [], float), np.asarray(samples.get("s") or [], float)
    timed = len(t) > 1 and len(at) == len(t)
    if timed:
        moments = np.interp(s, at, t)
        names = _owned(names, record, samples, moments)
        names = _steady(names, _reached(names, record, samples, moments))
    starts = [0, *(i for i in range(1, len(s) - 1) if names[i] != names[i - 1])]
    found: list[dict[str, Any]] = []
    for i, after in zip(starts, [*starts[1:], len(s) - 1], strict=True):
        row: dict[str, Any] = {"from": float(s[i]), "to": float(s[after]), "name": names[i], **named(names[i], joints)}
        if timed:
            row["begins"], row["ends"] = (float(value) for value in np.interp([s[i], s[after]], at, t))
        found.append(row)
    return found


def _steady(names: Sequence[str | None], reached: Mapping[str, NDArray[np.bool_]]) -> list[str | None]:
    """Names of active constraints, each kept as long as its own limit is ``reached``."""
    found = list(names)
    for i in range(1, len(found)):
        before = found[i - 1]
        if before is not None and before in reached and reached[before][i]:
            found[i] = before
    return found


LIMITED = {"speed": "qd", "acceleration": "qdd", "deceleration": "qdd", "torque": "tau", "jerk": "qddd"}
"""Kinds of limits of joints, and the samples that they bound."""


def _shares(kind: str, record: Mapping[str, Any], samples: Mapping[str, Any], moments: Floats) -> Floats | None:
    """Shares (joints, n) of a kind of limit that joints use at moments (s); None where they are not known."""
    limits, key = record.get("limits"), LIMITED.get(kind)
    values = matrix(samples.get(key)) if key is not None else np.zeros((0, 0))
    most = vector(np.atleast_1d((limits if isinstance(limits, Mapping) else {}).get(kind) or []).tolist())
    if not values.size or len(most) not in (1, len(values)):
        return None
    t = np.asarray(samples["t"], float)
    return np.stack([np.interp(moments, t, np.abs(row)) for row in values / most.reshape(-1, 1)])


def _owned(names: Sequence[str | None], record: Mapping[str, Any], samples: Mapping[str, Any], moments: Floats) -> list[str | None]:
    """Names of active constraints; those of a kind of limit alone ("jerk") get the joint that uses most of its limit there."""
    joints, found = [str(name) for name in listed(record.get("joints"))], list(names)
    for kind in {name for name in names if name in LIMITED}:
        shares = _shares(kind, record, samples, moments)
        if shares is not None and len(shares) == len(joints):
            first = shares.argmax(axis=0)
            found = [f"{kind} of {joints[first[i]]}" if name == kind else name for i, name in enumerate(found)]
    return found


def _reached(names: Sequence[str | None], record: Mapping[str, Any], samples: Mapping[str, Any], moments: Floats) -> dict[str, NDArray[np.bool_]]:
    """By name of an active constraint, whether its limit is reached at each moment (s), or as nearly as any of the kind that is named there."""
    joints = [str(name) for name in listed(record.get("joints"))]
    found: dict[str, NDArray[np.bool_]] = {}
    for text in {name for name in names if name is not None}:
        kind, joint = named(text, joints).values()
        shares = _shares(kind or "", record, samples, moments)
        if shares is not None and joint is not None:
            alike = np.array([named(name, joints)["kind"] == kind for name in names])
            found[text] = (shares[joint] > REACHED) | (alike & (shares[joint] >= REACHED * shares.max(axis=0)))
    return found


def named(text: str | None, joints: Sequence[str]) -> dict[str, Any]:
    """Kind and joint of a constraint such as "torque of elbow_joint" or "speed of joint 2"."""
    kind, _, owner = (text or "").partition(" of ")
    number = re.fullmatch(r"joint (\d+)", owner)
    joint = joints.index(owner) if owner in joints else int(number[1]) - 1 if number and int(number[1]) <= len(joints) else None
    return {"kind": kind.replace("_", " ") or None, "joint": joint}
