"""What the logs say about the unknown numbers: Bayesian least squares over all samples of all trials, older trials counting less."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from guideway.arm.learning.log import Log, smooth
from guideway.arm.learning.measured import measured
from guideway.arm.learning.task import Task
from guideway.arm.learning.unknown import Unknown
from guideway.arm.model import direction

Floats = NDArray[np.float64]

LAGS = 4
"""Delays of the torque signal that are tried, samples: 0 to 3."""
FOLLOWED, AWAY = 0.006, 0.01
"""A joint does as it was asked where its speed over twice that time (s) is within this (rad/s), and a fifth, of what it should be."""
STUCK = 0.3
"""Time after a turn (s) in which that is looked at."""
LEAST = 3
"""Trials from which on it is looked whether friction warms up."""
QUIET = 15
"""Samples of the moving average that a gear's ripple is taken to multiply."""


@dataclass(frozen=True)
class Samples:
    """Of one trial as it was measured, a row per sample (n, joints): joint angles ``q``, torques ``tau`` without their noise, measured less nominal
    torques ``left``, how the unknown numbers enter (n, joints, width), and where the arm was ``following`` its reference."""

    q: Floats
    tau: Floats
    left: Floats
    effects: Floats
    following: NDArray[np.bool_]


@dataclass(frozen=True)
class Evidence:
    """A trial as the regression needs it. Normal equations of each joint's own numbers, of the motion as it was measured: ``square`` (joints, w, w),
    ``cross`` (joints, w), ``samples``; noise ``sigma`` (joints,), N m. For what is left over, means over the samples in each of B bins of the path in
    which the joint followed its reference: ``counts`` (B, joints), measured torque less the nominal one of the reference ``left`` (B, joints), how
    the unknown numbers enter the reference ``effects`` (B, joints, w), and the conditions ``u``, ``x`` (B,) it was measured under."""

    square: Floats
    cross: Floats
    samples: int
    sigma: Floats
    counts: Floats
    left: Floats
    effects: Floats
    u: Floats
    x: Floats


def evidence(task: Task, log: Log, unknown: Unknown, lag: int | None, bins: int) -> tuple[Evidence, Samples, int]:
    """A log as evidence, its samples, and the delay of its torques in samples (found where ``lag`` is None)."""
    seen, x, ways = log.reference, log.reference.speed**2, direction(log.reference.q1)
    asked = (seen.q, seen.qd, seen.qdd, ways)
    moved = measured(log)
    sigma, following = np.maximum(log.noise, 1e-3 * task.torque), _following(log, ways)
    real = moved or asked
    nominal, plain = task.dynamics.moving(*real)
    if lag is None:
        lag = _lag(log.tau, nominal, Unknown(task, False), plain, sigma, following & (ways != 0))
    count = len(log.t) - lag
    tau, following = smooth(log.tau, QUIET)[lag:], following[:count]

    def entering(motion: tuple[Floats, ...], nominal: Floats, plain: Floats) -> tuple[Floats, Floats]:
        q, qd, _, ways = (part[:count] for part in motion)
        return log.tau[lag:] - nominal[:count], unknown.effects(plain[:count], qd, ways, q, tau)

    left, effects = entering(real, nominal, plain)
    again = (left, effects) if moved is None else entering(asked, *task.dynamics.moving(*asked))
    place = np.minimum((seen.s[:count] / task.s[-1] * bins).astype(int), bins - 1)
    sums = _sums(place, bins)
    counts, all_ = sums(following.astype(float)), np.maximum(sums(np.ones(count)), 1.0)
    each = np.maximum(counts, 1.0)
    means = sums(again[0] * following) / each, sums(again[1] * following[..., None]) / each[..., None]
    conditions = sums(seen.u[:count]) / all_, sums(x[:count]) / all_
    moves = following & (ways[:count] != 0)  # a joint that stands still holds by its friction, of any size: it says nothing about the load
    found = Evidence(*_normal(effects, left, moves), count, sigma, counts, *means, *conditions)
    return found, Samples(real[0][:count], tau, left, effects, following), lag


def _following(log: Log, ways: Floats) -> NDArray[np.bool_]:
    """Where each joint moves as it was asked to, (n, joints). For a while after it starts or turns round it may stick: friction has any size then,
    and such samples say nothing."""
    half = max(1, round(FOLLOWED / np.median(np.diff(log.t))))
    wide = (log.t[2 * half :] - log.t[: -2 * half])[:, None]
    measured, asked = ((q[2 * half :] - q[: -2 * half]) / wide for q in (log.q, log.reference.q))
    good = np.abs(measured - asked) <= AWAY + 0.2 * np.abs(asked)
    good = np.concatenate([np.repeat(good[:1], half, 0), good, np.repeat(good[-1:], half, 0)])
    turned = np.concatenate([np.ones((1, ways.shape[1]), bool), ways[1:] != ways[:-1]])
    since = log.t[:, None] - np.maximum.accumulate(np.where(turned, log.t[:, None], -np.inf), 0)
    return np.asarray(good | (since > STUCK))


def _normal(effects: Floats, left: Floats, following: NDArray[np.bool_]) -> tuple[Floats, Floats]:
    """Normal equations of each joint, (joints, w, w) and (joints, w)."""
    own = np.ascontiguousarray((effects * following[..., None]).transpose(1, 0, 2))
    return own.transpose(0, 2, 1) @ own, (own.transpose(0, 2, 1) @ left.T[:, :, None])[:, :, 0]


def _sums(place: NDArray[np.intp], bins: int) -> Callable[[Floats], Floats]:
    """Sums over bins as a function of sampled values."""
    order = np.argsort(place, kind="stable")
    filled = np.flatnonzero(np.bincount(place, minlength=bins))
    starts = np.searchsorted(place[order], filled)

    def total(values: Floats) -> Floats:
        found = np.zeros((bins, *values.shape[1:]))
        found[filled] = np.add.reduceat(values[order], starts, axis=0)
        return found

    return total


def _lag(tau: Floats, nominal: Floats, unknown: Unknown, effects: Floats, sigma: Floats, following: NDArray[np.bool_]) -> int:
    """The delay under which the structure explains the torques best."""
    errors, count = [], len(tau) - LAGS
    for lag in range(LAGS):
        y = tau[lag : lag + count] - nominal[:count]
        square, cross = _normal(effects[:count], y, following[:count])
        normal, right = assembled(unknown, square / sigma[:, None, None] ** 2, cross / sigma[:, None] ** 2)
        scale = np.sqrt(np.diag(normal)) + 1e-12
        solved = np.linalg.solve(normal / np.outer(scale, scale) + 1e-9 * np.eye(len(scale)), right / scale) / scale
        errors.append(float(((following[:count] * (y - predicted(unknown, effects[:count], solved)) / sigma) ** 2).sum()))
    return int(np.argmin(errors))


def assembled(unknown: Unknown, square: Floats, cross: Floats) -> tuple[Floats, Floats]:
    """Normal equations of all numbers, (p, p) and (p,), from those of each joint."""
    normal, right = np.zeros((unknown.count, unknown.count)), np.zeros(unknown.count)
    for own, part, side in zip(unknown.index, square, cross, strict=True):
        normal[np.ix_(own, own)] += part
        right[own] += side
    return normal, right


def predicted(unknown: Unknown, effects: Floats, numbers: Floats) -> Floats:
    """Torques (n, joints) that the numbers (p,) make by ``effects`` (n, joints, width)."""
    return np.einsum("njw,jw->nj", effects, numbers[unknown.index])


@dataclass(frozen=True)
class Posterior:
    """What is believed about the ``unknown`` numbers in the trial to come: their ``mean`` (p,) and ``covariance`` (p, p). Friction warms up: from
    trial to trial ``rubbing`` (p,), the numbers that are friction, change by the share ``warming``, known to a standard deviation of ``unsure``."""

    unknown: Unknown
    mean: Floats
    covariance: Floats
    rubbing: Floats
    warming: float = 0.0
    unsure: float = 0.0

    def before(self, back: int) -> Floats:
        """The numbers (p,) as they were ``back`` trials before the one to come."""
        return self.mean - back * self.warming * self.rubbing

    def spread(self, effects: Floats) -> Floats:
        """Standard deviation (n, joints) of a torque, N m, into which the numbers enter by ``effects`` (n, joints, width)."""
        own = self.unknown.index
        blocks = self.covariance[own[:, :, None], own[:, None, :]]
        each = effects.transpose(1, 0, 2)
        return np.sqrt(np.maximum(((each @ blocks) * each).sum(-1), 0.0)).T


def posterior(trials: list[Evidence], unknown: Unknown, forget: float, inflation: Floats, warming: float = 0.0) -> Posterior:
    """All trials together; each counts ``forget`` times less than the next. ``inflation`` (joints,) is by how much the variance of a sample is
    larger than its noise because what is left over is alike from sample to sample. ``warming``: standard deviation, before the trials, of the share
    by which friction changes from one to the next, the same in all joints; from three trials on it is estimated."""
    weights = [forget**age / (trial.sigma**2 * inflation) for age, trial in enumerate(reversed(trials))][::-1]
    square = sum(weight[:, None, None] * trial.square for weight, trial in zip(weights, trials, strict=True))
    cross = sum(weight[:, None] * trial.cross for weight, trial in zip(weights, trials, strict=True))
    normal, right = assembled(unknown, np.asarray(square), np.asarray(cross))
    mean, covariance = _solved(normal, right, unknown.sizes)
    rubbing = np.where(unknown.rubs, mean, 0.0)
    if not warming or len(trials) < LEAST:
        return Posterior(unknown, mean, covariance, rubbing)
    # friction in trial k is friction * (1 + k warming), k counted back from the trial to come: one number more, whose effect is k times that of
    # friction, so its equations follow from those of the others
    count, own = unknown.count, rubbing[unknown.index]
    normal, right = np.pad(normal, (0, 1)), np.pad(right, (0, 1))
    for back, (weight, trial) in enumerate(zip(reversed(weights), reversed(trials), strict=True), 1):
        mixed = -back * weight[:, None] * np.einsum("jab,jb->ja", trial.square, own)
        for index, part in zip(unknown.index, mixed, strict=True):
            normal[index, count] += part
        normal[count, count] -= back * float((mixed * own).sum())
        right[count] -= back * float((weight[:, None] * trial.cross * own).sum())
    normal[count, :count] = normal[:count, count]
    mean, covariance = _solved(normal, right, np.append(unknown.sizes, warming))
    unsure = float(np.sqrt(covariance[count, count]))
    return Posterior(unknown, mean[:count], covariance[:count, :count], rubbing, float(mean[count]), unsure)


def _solved(normal: Floats, right: Floats, sizes: Floats) -> tuple[Floats, Floats]:
    """Mean (p,) and covariance (p, p) of numbers of these sizes before anything was measured."""
    covariance = np.linalg.inv(np.eye(len(sizes)) + normal * np.outer(sizes, sizes))
    return sizes * (covariance @ (right * sizes)), covariance * np.outer(sizes, sizes)
