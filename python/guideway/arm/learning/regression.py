"""What the logs say about the unknown numbers: Bayesian least squares over all samples of all trials, older trials counting less."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from guideway.arm.learning.dynamics import OF_A_JOINT, PAYLOAD
from guideway.arm.learning.log import Log
from guideway.arm.learning.task import Task

Floats = NDArray[np.float64]

LAGS = 4
"""Delays of the torque signal that are tried, samples: 0 to 3."""


@dataclass(frozen=True)
class Evidence:
    """A trial as the regression needs it. Normal equations per joint: ``square`` (joints, p, p), ``cross`` (joints, p), ``samples``; noise ``sigma``
    (joints,), N m. For what is left over, means over the samples in each of B bins of the path: ``counts`` (B,), measured less nominal torque
    ``left`` (B, joints), how the unknown numbers enter it ``effects`` (B, joints, p), and the conditions ``u``, ``x`` (B,) it was measured under."""

    square: Floats
    cross: Floats
    samples: int
    sigma: Floats
    counts: Floats
    left: Floats
    effects: Floats
    u: Floats
    x: Floats


def evidence(task: Task, log: Log, lag: int | None, bins: int) -> tuple[Evidence, int]:
    """A log as evidence, and the delay of its torques in samples (found where ``lag`` is None)."""
    seen = log.reference
    path = task.path.eval(seen.s, 2)
    x = seen.speed**2
    left = log.tau - task.dynamics.nominal(*path).at(seen.u, x)
    nominal = log.tau - left
    effects = task.dynamics.parameters(*path).at(seen.u, x)
    floor = 1e-3 * task.torque
    sigma = np.maximum(log.noise, floor)
    lag = _lag(log.tau, nominal, effects, sigma) if lag is None else lag
    count = len(log.t) - lag
    left, effects = log.tau[lag:] - nominal[:count], effects[:count]
    place = np.minimum((seen.s[:count] / task.s[-1] * bins).astype(int), bins - 1)
    counts = np.bincount(place, minlength=bins).astype(float)
    mean = _means(place, counts)
    found = Evidence(
        np.einsum("njp,njq->jpq", effects, effects),
        np.einsum("njp,nj->jp", effects, left),
        count,
        sigma,
        counts,
        mean(left),
        mean(effects),
        mean(seen.u[:count]),
        mean(x[:count]),
    )
    return found, lag


def _means(place: NDArray[np.intp], counts: Floats):
    """Means over bins as a function of sampled values."""
    order = np.argsort(place, kind="stable")
    filled = np.flatnonzero(counts)
    starts = np.searchsorted(place[order], filled)

    def mean(values: Floats) -> Floats:
        found = np.zeros((len(counts), *values.shape[1:]))
        found[filled] = np.add.reduceat(values[order], starts, axis=0) / counts[filled].reshape(-1, *(1,) * (values.ndim - 1))
        return found

    return mean


def _lag(tau: Floats, nominal: Floats, effects: Floats, sigma: Floats) -> int:
    """The delay under which the structure explains the torques best."""
    errors = []
    for lag in range(LAGS):
        count = len(tau) - LAGS
        y = ((tau[lag : lag + count] - nominal[:count]) / sigma).ravel()
        a = (effects[:count] / sigma[:, None]).reshape(len(y), -1)
        normal = a.T @ a
        scale = np.sqrt(np.diag(normal)) + 1e-12
        normal = normal / np.outer(scale, scale) + 1e-9 * np.eye(len(scale))
        solved = np.linalg.solve(normal, a.T @ y / scale) / scale
        errors.append(float(((y - a @ solved) ** 2).sum()))
    return int(np.argmin(errors))


def prior(task: Task) -> Floats:
    """Standard deviations of the unknown numbers before the first trial: a payload as heavy as the arm could hold with nothing else to do, friction
    of half of each joint's torque."""
    reach = np.abs(task.nominal.c).max() / max(9.81 * _moved_mass(task), 1e-9)
    mass = float(task.torque.max()) / (9.81 * max(reach, 0.05))
    arm = 0.3 * reach
    inertial = [mass, *[mass * arm] * 3, *[mass * arm * arm] * 6]
    half = 0.5 * task.torque
    sizes = {
        "viscous": half / task.speed,
        "coulomb": half,
        "offset": 0.2 * half,
        "viscous asymmetry": 0.2 * half / task.speed,
        "rotor": 0.2 * half / task.acceleration,
    }
    return np.concatenate([inertial[:PAYLOAD], *[sizes[name] for name in OF_A_JOINT]])


def _moved_mass(task: Task) -> float:
    return float(sum(inertia.mass for inertia in list(task.arm.model.inertias)[2:]))


@dataclass(frozen=True)
class Posterior:
    """What is believed about the unknown numbers: their ``mean`` (p,) and ``covariance`` (p, p)."""

    mean: Floats
    covariance: Floats

    def spread(self, effects: Floats) -> Floats:
        """Standard deviation (N m) of a torque into which the numbers enter by ``effects`` (..., p)."""
        return np.sqrt(np.maximum(np.einsum("...p,pq,...q->...", effects, self.covariance, effects), 0.0))


def posterior(trials: list[Evidence], sizes: Floats, forget: float, inflation: Floats) -> Posterior:
    """All trials together; each counts ``forget`` times less than the next. ``inflation`` (joints,) is by how much the variance of a sample is
    larger than its noise because what is left over is alike from sample to sample."""
    count = len(sizes)
    normal, right = np.eye(count), np.zeros(count)
    for age, trial in enumerate(reversed(trials)):
        weight = forget**age / (trial.sigma**2 * inflation)
        normal += np.einsum("j,jpq->pq", weight, trial.square) * np.outer(sizes, sizes)
        right += np.einsum("j,jp->p", weight, trial.cross) * sizes
    covariance = np.linalg.inv(normal)
    return Posterior(sizes * (covariance @ right), covariance * np.outer(sizes, sizes))
