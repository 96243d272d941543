"""Logs of real trials: a CSV file with the time, measured joint angles and measured torques, and what it says about the motion along the path."""

from __future__ import annotations

import os
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from guideway.arm.learning.log import Log, smooth
from guideway.arm.learning.motion import Motion, Sampled
from guideway.arm.learning.task import Task
from guideway.errors import BadFile

Floats = NDArray[np.float64]

LEAST = 50
"""Rows of a log, at the least."""
STEPS = (1e-4, 0.05)
"""Between its rows, s."""
HOLE = 0.05
"""Longest time without a sample, s, and no more than ten times the usual one."""
UNIT = 8.0
"""Measured torques that are so many times larger or smaller than those of the arm alone are in another unit."""
KNOWN = 0.05
"""Where the arm alone takes less than this share of its torques, nothing can be said about the unit."""
AWAY = 0.05
"""Distance from the path (rad, over all joints) from which a log is that of another path."""
ENDS = 0.02
"""Share of the path's length that may be missing at either end."""
CLOCK = 0.02
"""A trial that passes every place within this time (s) of the planned one was the planned motion."""
TRACE = 4000
"""Points of the path that measured angles are compared with."""


@dataclass(frozen=True)
class Measured:
    """A log as a file has it: ``t`` (n,) s from 0, ``q`` and ``tau`` (n, joints), rad and N m; ``where`` for messages."""

    where: str
    t: Floats
    q: Floats
    tau: Floats


def load_log(path: str | os.PathLike[str], names: tuple[str, ...]) -> Measured:
    """Reads a log: a header, then a row per sample. Columns: ``t`` (s); the angle of each joint under its name, ``q_NAME`` or ``q1``, ``q2`` ...
    (rad); its torque under ``NAME_torque``, ``NAME_effort``, ``tau_NAME`` or ``tau1``, ``tau2`` ... (N m). Others are left alone.

    Raises :class:`guideway.errors.BadFile` for missing columns, values that are no finite numbers, a time that does not increase, and too few rows.
    """
    from guideway.io.files import load, name, show
    from guideway.io.tables import parse_csv

    where, text = name(path), load(path).text()
    first = next((line for line in text.split("\n") if line.strip()), "")
    header = tuple(word.strip() for word in first.split(","))
    if len(set(header)) != len(header) or not all(header):
        raise BadFile(where, f"the header is {show(first)}", "different names of columns, separated by commas", "Correct the first line")
    _whole(where, text, len(header))
    columns = [_column(where, header, ("t", "time"))]
    for kinds in (("{name}", "q_{name}", "q{k}"), ("{name}_torque", "{name}_effort", "tau_{name}", "tau{k}")):
        columns += [_column(where, header, tuple(kind.format(name=joint, k=k + 1) for kind in kinds)) for k, joint in enumerate(names)]
    table = np.array(parse_csv(where, text, header))
    if len(table) < LEAST:
        raise BadFile(where, f"the log has {len(table)} rows", f"at least {LEAST}", "Record the whole trial, 100 to 1000 samples a second")
    table = table[:, columns]
    if (np.diff(table[:, 0]) <= 0).any():
        row = int(np.argmax(np.diff(table[:, 0]) <= 0)) + 3
        raise BadFile(f"{where}, row {row}", "the time does not increase", "t in s, one row after the other", "Sort the log, drop repeated samples")
    joints = len(names)
    found = Measured(where, table[:, 0] - table[0, 0], table[:, 1 : 1 + joints], table[:, 1 + joints :])
    _sampled(found, table[0, 0])
    return found


def _whole(where: str, text: str, columns: int) -> None:
    """Refuses a file whose last line is cut off."""
    lines = text.rstrip().split("\n")
    if len(lines) > 2 and not text.endswith("\n") and lines[-1].count(",") + 1 < columns == lines[-2].count(",") + 1:
        allowed = f"{columns} numbers in each row"
        raise BadFile(
            f"{where}, line {len(lines)}", "the file ends in the middle of a row: it is cut", allowed, "Copy the log again, or record again"
        )


def _sampled(found: Measured, start: float) -> None:
    """Refuses logs with the wrong unit of time, with holes, and without torques."""
    step = np.diff(found.t)
    usual = float(np.median(step))
    if not STEPS[0] <= usual <= STEPS[1]:
        allowed = f"from {STEPS[0]:g} to {STEPS[1]:g} s"
        raise BadFile(found.where, f"its samples are {usual:g} s apart", allowed, "State t in seconds, record 100 to 1000 samples a second")
    hole = int(np.argmax(step))
    if step[hole] > max(10 * usual, HOLE):
        what = f"there are no samples between t = {start + found.t[hole]:.3f} and {start + found.t[hole + 1]:.3f} s: a piece is missing"
        raise BadFile(found.where, what, f"gaps of at most {max(10 * usual, HOLE):g} s", "Record the whole trial in one piece")
    if (np.ptp(found.tau, axis=0) == 0).all():
        what = f"its torques never change (the first one is {found.tau[0, 0]:g} N m throughout)"
        raise BadFile(found.where, what, "measured joint torques in N m", "Record torques, not a setting")


def _column(where: str, header: tuple[str, ...], allowed: tuple[str, ...]) -> int:
    found = [header.index(title) for title in allowed if title in header]
    if not found:
        raise BadFile(where, f"the log has no column {allowed[0]!r}", " or ".join(allowed), "Name the columns after the joints of this robot")
    return found[0]


def as_log(task: Task, measured: Measured, motion: Motion | None) -> tuple[Log, bool]:
    """A file's log as one of a trial on the task's path. Was the trial the planned ``motion``? Then its clock says where the arm was, else the
    angles do.

    Raises :class:`guideway.errors.BadFile` for a log of another path, and for one that does not reach the end.
    """
    measured = _turned(task, measured)
    s = _places(task, measured)
    _plausible(task, measured, s)
    start, end = _moving(measured, s, task)
    t, s = measured.t[start:end], s[start:end]
    if motion is not None:
        levels = np.linspace(0.05, 0.95, 19) * task.s[-1]
        planned = np.interp(levels, motion.s, motion.times)
        shift = np.interp(levels, np.maximum.accumulate(s), t) - planned
        middle = float(np.median(shift))
        if np.abs(shift - middle).max() <= CLOCK:
            inside = (measured.t >= middle - 1e-9) & (measured.t <= middle + motion.duration + 1e-9)
            return Log(motion, measured.t[inside] - middle, measured.q[inside], measured.tau[inside]), True
    seen = _own_clock(task, t, s)
    rough = Motion(task.path, task.s, _squares(task, seen))
    return Log(rough, t - t[0], measured.q[start:end], measured.tau[start:end], seen=seen), False


def _turned(task: Task, measured: Measured) -> Measured:
    """The log with whole turns taken off angles that start whole turns away from the path; refuses degrees."""
    first = task.path.eval(np.zeros(1))[0][0]
    turns = np.round((measured.q[0] - first) / (2 * np.pi))
    if np.abs(np.radians(measured.q[0]) - first).max() < AWAY < np.abs(measured.q[0] - 2 * np.pi * turns - first).max():
        what = f"its angles look like degrees: the first one is {measured.q[0, 0]:g}, the path begins at {first[0]:.4f} rad"
        raise BadFile(measured.where, what, "angles in rad", "Multiply them by pi / 180")
    return replace(measured, q=measured.q - 2 * np.pi * turns)


def _plausible(task: Task, measured: Measured, s: Floats) -> None:
    """Refuses torques with the wrong sign or in another unit, as far as what the arm alone weighs tells."""
    weight = task.dynamics.nominal(*task.path.eval(s, 2)).c / task.torque
    tau = measured.tau / task.torque
    if np.sqrt((weight**2).mean(0)).max() < KNOWN:
        return
    ratio = float((tau * weight).sum() / (weight**2).sum())
    size = float(np.sqrt((tau**2).sum() / (weight**2).sum()))
    if ratio < -0.3 * size:
        what = "its torques have the wrong sign: they point down where the arm must be held up"
        raise BadFile(measured.where, what, "torques that lift the arm where its angle grows upwards, N m", "Turn the sign of the torques round")
    if not 1 / UNIT <= size <= UNIT:
        what = f"its torques are {size:.3g} times those that the arm alone takes to be held"
        raise BadFile(
            measured.where, what, f"from {1 / UNIT:g} to {UNIT:g} times", "State torques of the joints in N m, or correct the robot's masses"
        )


def _places(task: Task, measured: Measured) -> Floats:
    """Where on the path each sample is: nearest points, forwards only (with a little play), from the start on."""
    trace = np.linspace(0.0, task.s[-1], TRACE + 1)
    there, ahead = task.path.eval(trace)[0], TRACE // 20
    found, at = np.empty(len(measured.q)), 0
    gaps = np.empty(len(measured.q))
    for k, q in enumerate(measured.q):
        low = max(at - 8, 0)
        apart = ((there[low : at + ahead] - q) ** 2).sum(1)
        near = int(np.argmin(apart))
        at = max(at, low + near) if k else near
        found[k], gaps[k] = trace[low + near], np.sqrt(apart[near])
    if gaps.max() > AWAY:
        worst = int(np.argmax(gaps > AWAY))
        raise BadFile(
            measured.where,
            f"from t = {measured.t[worst]:.3f} s of the log on the arm is up to {gaps.max():.3f} rad away from the path: "
            "this is the log of another path, or the joints are mixed up",
            f"at most {AWAY:g} rad",
            "Name the log of a trial on this path",
        )
    for _ in range(3):
        q, q1 = task.path.eval(found, 1)
        found = np.clip(found + ((measured.q - q) * q1).sum(1), 0.0, task.s[-1])
    if found[0] > ENDS * task.s[-1] or found[-1] < (1 - ENDS) * task.s[-1]:
        raise BadFile(
            measured.where,
            f"the log goes from {100 * found[0] / task.s[-1]:.0f} % to {100 * found[-1] / task.s[-1]:.0f} % of the path: it is cut",
            "the whole path, from rest to rest",
            "Record the whole trial",
        )
    return found


def _moving(measured: Measured, s: Floats, task: Task) -> tuple[int, int]:
    """First and last sample of the motion, without the standstill before and after it."""
    away = 1e-4 * task.s[-1]
    start = int(np.argmax(s > away))
    end = len(s) - int(np.argmax(s[::-1] < task.s[-1] - away))
    return max(start - 1, 0), min(end + 1, len(s))


def _own_clock(task: Task, t: Floats, s: Floats) -> Sampled:
    """Speed and acceleration along the path from the angles alone: local parabolas over 40 ms."""
    half = max(3, int(np.ceil(0.02 / np.median(np.diff(t)))))
    smoothed, speed, u = np.empty_like(s), np.empty_like(s), np.empty_like(s)
    for k in range(len(s)):
        low, high = max(k - half, 0), min(k + half + 1, len(s))
        fitted = np.polynomial.polynomial.polyfit(t[low:high] - t[k], s[low:high], 2)
        smoothed[k], speed[k], u[k] = fitted[0], max(fitted[1], 0.0), 2 * fitted[2]
    smoothed = np.clip(smoothed, 0.0, task.s[-1])
    q, q1, q2 = task.path.eval(smoothed, 2)
    return Sampled(t - t[0], smoothed, speed, u, q, q1 * speed[:, None], q1 * u[:, None] + q2 * (speed**2)[:, None], q1)


def _squares(task: Task, seen: Sampled) -> Floats:
    """Squared speeds on the task's grid, as the trial had them."""
    order = np.argsort(seen.s, kind="stable")
    x = np.interp(task.s, seen.s[order], smooth(seen.speed[order] ** 2, 3))
    x[1:-1] = np.maximum(x[1:-1], 1e-6)
    x[[0, -1]] = 0.0
    return x
