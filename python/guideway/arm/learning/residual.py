"""What the structure does not explain, as a Gaussian process over the path: ripple, Stribeck, an inexact nominal model, drift."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from guideway.arm.learning.regression import Evidence, Posterior, predicted

Floats = NDArray[np.float64]

LATELY = 3
"""Trials, the newest ones, that say how large it is."""
NEAR = 4
"""Bins either way over which a place is looked at alone."""
APART = 12.0
"""It stands out where neighbours are that many times more alike than usual."""


@dataclass(frozen=True)
class Residual:
    """Mean and standard deviation (N m, (B, joints)) in the bins of the path."""

    mean: Floats
    spread: Floats

    def on(self, share: Floats) -> tuple[Floats, Floats]:
        """Both at shares (n,) of the path's length, 0 to 1."""
        bins, joints = self.mean.shape
        place = np.clip(share * bins - 0.5, 0, bins - 1)
        at = np.arange(bins)
        return tuple(np.stack([np.interp(place, at, values[:, j]) for j in range(joints)], 1) for values in (self.mean, self.spread))  # type: ignore[return-value]


def amplitude(trials: list[Evidence], belief: Posterior) -> Floats:
    """Root mean square (B, joints) of what is left over and alike in neighbouring bins: noise is not, so it drops out. It is that of the whole path,
    but of the neighbourhood where that stands out (a joint that turns round, a place where the arm does not follow). The newest trials count, but not
    the very first, which is slow and in which the controller knew nothing of the load."""
    newest = trials[max(1, len(trials) - LATELY) :] or trials
    both = np.stack([((trial.counts[1:] > 0) & (trial.counts[:-1] > 0)).astype(float) for trial in newest])
    left = np.stack([_left(trial, belief, back) for back, trial in zip(range(len(newest), 0, -1), newest, strict=True)])
    product = left[:, 1:] * left[:, :-1] * both
    near, count = _around(product.sum(0)), _around(both.sum(0))
    met = both.any((0, 1))
    usual = np.where(met, np.nanmedian(np.where((both > 0) | ~met, np.abs(product), np.nan), (0, 1)), np.abs(product).max((0, 1)))
    apart = near > count * np.maximum(APART * usual, 1e-300)
    calm = both * ~apart
    whole = np.maximum(calm.sum((0, 1)), 1.0)
    level = (calm * product).sum((0, 1)) / whole
    doubt = np.sqrt((calm * (product - level) ** 2).sum((0, 1))) / whole
    found = np.where(apart, near / np.maximum(count, 1.0), level + doubt)
    found = np.maximum(np.concatenate([found[:1], found]), np.concatenate([found, found[-1:]]))
    return np.sqrt(np.maximum(found, 0.0))


def _left(trial: Evidence, belief: Posterior, back: int) -> Floats:
    """What the numbers leave over of a trial, ``back`` trials before the one to come."""
    return trial.left - predicted(belief.unknown, trial.effects, belief.before(back))


def _around(values: Floats) -> Floats:
    """Sums over a window of bins."""
    total = np.concatenate([np.zeros((1, values.shape[1])), np.cumsum(values, 0)])
    at = np.arange(len(values))
    return total[np.minimum(at + NEAR + 1, len(values))] - total[np.maximum(at - NEAR, 0)]


def condition(trials: list[Evidence], belief: Posterior, size: Floats, age: list[Floats], length: float) -> Residual:
    """The process given what every trial left over. ``size`` (B, joints) is its amplitude, ``length`` its correlation length in bins, ``age`` per
    trial the share (B, joints) of its variance that the trial says nothing about, because it was run under other conditions or long ago."""
    bins, joints = trials[0].left.shape
    weight, right = np.full((bins, joints), 1e-12), np.zeros((bins, joints))
    for back, trial, old in zip(range(len(trials), 0, -1), trials, age, strict=True):
        variance = trial.sigma**2 / np.maximum(trial.counts, 1.0) + old * size**2
        share = np.where(trial.counts > 0, 1.0 / np.maximum(variance, 1e-12), 0.0)
        weight += share
        right += share * _left(trial, belief, back)
    mean, spread = smoothed(right / weight / size, 1.0 / weight / size**2, np.ones(joints), float(np.exp(-1.0 / length)))
    return Residual(size * mean, size * spread)


def smoothed(values: Floats, variances: Floats, size: Floats, alike: float) -> tuple[Floats, Floats]:
    """Mean and standard deviation (B, joints) of an Ornstein-Uhlenbeck process (exponential kernel: neighbours are ``alike`` correlated, amplitude
    ``size``) given noisy values. The process is a Markov chain, so a pass forwards and one backwards are all it takes."""
    bins = len(values)
    mean, variance = np.zeros_like(values), np.zeros_like(values)
    guess, doubt = np.zeros_like(size), size**2
    for k in range(bins):
        gain = doubt / (doubt + variances[k])
        mean[k], variance[k] = guess + gain * (values[k] - guess), (1 - gain) * doubt
        guess, doubt = alike * mean[k], alike**2 * variance[k] + (1 - alike**2) * size**2
    for k in range(bins - 2, -1, -1):
        ahead = alike**2 * variance[k] + (1 - alike**2) * size**2
        back = alike * variance[k] / np.maximum(ahead, 1e-300)
        mean[k] += back * (mean[k + 1] - alike * mean[k])
        variance[k] += back**2 * (variance[k + 1] - ahead)
    return mean, np.sqrt(np.maximum(variance, 0.0))
