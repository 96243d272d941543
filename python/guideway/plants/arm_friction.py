"""Friction of simulated joints: viscous and Coulomb, and what a real joint has beside them."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from guideway.errors import BadParameter

Floats = NDArray[np.float64]

KINDS = ("none", "reference", "full")


@dataclass(frozen=True)
class JointFriction:
    """Friction torque of joints. Every effect beyond ``viscous`` (N m s/rad) and ``coulomb`` (N m) is off at 0.

    ``smooth`` (rad/s) softens the sign to ``tanh(qd / smooth)``; ``stribeck`` is the share by which Coulomb friction rises below ``stribeck_speed``
    (rad/s); ``asymmetry`` the share by which all of it is larger forwards and smaller backwards; ``ripple`` the share of the whole joint torque that
    comes and goes ``cycles`` times a turn of the joint (twice a turn of a gear's fast side, ratio 101); ``drift`` the share lost over
    ``drift_trials`` trials.
    """

    viscous: tuple[float, ...]
    coulomb: tuple[float, ...]
    smooth: float = 0.0
    stribeck: float = 0.0
    stribeck_speed: float = 0.05
    asymmetry: float = 0.0
    ripple: float = 0.0
    cycles: float = 202.0
    drift: float = 0.0
    drift_trials: int = 30

    @staticmethod
    def of(kind: str, viscous: tuple[float, ...], coulomb: tuple[float, ...]) -> JointFriction:
        """``none``, ``reference`` (viscous and Coulomb with a plain sign) or ``full`` (all effects)."""
        if kind not in KINDS:
            raise BadParameter(f"friction {kind!r} is not known: one of {', '.join(KINDS)}")
        if kind == "none":
            return JointFriction((0.0,) * len(viscous), (0.0,) * len(coulomb))
        plain = JointFriction(viscous, coulomb)
        return plain if kind == "reference" else replace(plain, smooth=0.02, stribeck=0.2, asymmetry=0.1, ripple=0.01, drift=-0.1)

    def scaled(self, factor: float) -> JointFriction:
        """The same with viscous and Coulomb friction times ``factor``."""
        return replace(self, viscous=tuple(factor * v for v in self.viscous), coulomb=tuple(factor * c for c in self.coulomb))

    def torque(self, qd: Floats, direction: Floats, trial: int = 0) -> Floats:
        """N m, (..., joints), at joint speeds ``qd``; ``direction`` says which way a joint goes where its speed is 0 (plain sign only)."""
        sign = np.tanh(qd / self.smooth) if self.smooth > 0 else np.sign(direction)
        return self.slope(direction, trial) * qd + self.grip(qd, direction, trial) * sign

    def grip(self, qd: Floats, direction: Floats, trial: int = 0) -> Floats:
        """Size of the Coulomb friction of joints at speeds ``qd`` that move that way, N m."""
        more = 1 + self.stribeck * np.exp(-((qd / self.stribeck_speed) ** 2)) if self.stribeck else 1.0
        return self._share(direction, trial) * np.asarray(self.coulomb) * more

    def slope(self, direction: Floats, trial: int = 0) -> Floats:
        """Viscous friction of joints that move that way, N m s/rad."""
        return self._share(direction, trial) * np.asarray(self.viscous)

    def _share(self, direction: Floats, trial: int) -> Floats:
        warm = 1 + self.drift * min(trial, self.drift_trials) / self.drift_trials
        return warm * (1 + self.asymmetry * np.sign(direction))

    def gain(self, q: Floats) -> Floats:
        """What the torque of the joint is multiplied by at joint angles ``q``: the ripple of its gear."""
        return 1 + self.ripple * np.sin(self.cycles * q) if self.ripple else np.ones_like(q)
