"""Measures by which motions of arms are compared: jerk, and what a motion takes of the motors."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

if TYPE_CHECKING:
    from guideway.arm.motion import ArmMotion

RATE = 1000.0
"""Samples per second."""


def measures(motion: ArmMotion) -> dict[str, float]:
    """Measures of a motion by their names.

    ``jerk_peak`` and ``jerk_rms`` (rad/s3, the worst joint) are from differences of the joint accelerations at 1 kHz. Where torques count there are
    also ``energy`` (J), the work that the motors put in without what braking gives back, and ``copper`` (s), the squares of the torques' shares of
    their limits summed over joints and time: what heats the windings.
    """
    sample = motion.sample(RATE)
    # the last step is shorter than the others
    dt = np.diff(sample["t"])
    if not dt.size:
        return {}
    jerk = np.diff(sample["qdd"], axis=0) / dt[:, None]
    found = {"jerk_peak": float(np.abs(jerk).max()), "jerk_rms": float(np.sqrt(dt @ jerk**2 / dt.sum()).max())}
    limit = motion.limits.per_joint("torque", len(motion.names))
    if motion.arm is None or limit is None:
        return found
    tau = motion.torques(sample)
    power, share = np.maximum(tau * sample["qd"], 0.0).sum(1), ((tau / limit) ** 2).sum(1)
    energy, copper = (float(dt @ (rate[1:] + rate[:-1]) / 2) for rate in (power, share))
    return found | {"energy": energy, "copper": copper}
