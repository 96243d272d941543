"""A figure of an arm's motion for papers: the phase plane, and the joints over time against their limits (by matplotlib)."""

from __future__ import annotations

import os
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np

from .arm_course import course, phase, stretches, vector
from .figure import figure_sheet, save
from .geometry import listed

JOINTS = ("#0072b2", "#c8500a", "#00805c", "#a04a82", "#8f6a00", "#5a52b5", "#2788a3", "#5b6770")
"""Colours of joints, as in the page."""
QUANTITIES = (
    ("qd", "speed", "speed", "rad/s"),
    ("qdd", "acceleration", "acceleration", "rad/s$^2$"),
    ("qddd", "jerk", "jerk", "rad/s$^3$"),
    ("tau", "torque", "torque", "N m"),
)


def arm_figure(record: Mapping[str, Any], path: str | os.PathLike[str]) -> list[Path]:
    """Writes the motion of ``traj.json`` as ``path`` with the endings ``.png`` (300 dpi) and ``.svg``; returns the two files.

    Above the phase plane, its profile in the colours of the joints that hold it back, with the trials and the true optimum of learning; below speed,
    acceleration, jerk and torque of all joints as shares of their limits, where there are some. Needs matplotlib, raises ``ImportError`` without it
    and ``ValueError`` where the record holds no motion.
    """
    samples = course(record)
    if len(samples["t"]) < 2:
        raise ValueError("this record holds no motion of an arm")
    shown = [row for row in QUANTITIES if listed(samples.get(row[0])) and not (row[0] == "qddd" and samples["jerky"])]
    lines = -(-len(shown) // 2)
    sheet = figure_sheet((7.2, 3.1 + 1.75 * lines))
    grid = sheet.add_gridspec(1 + lines, 2, height_ratios=(1.6, *(1.0 for _ in range(lines))))
    draw_phase(sheet.add_subplot(grid[0, :]), record, samples)
    for k, row in enumerate(shown):
        wide = k == len(shown) - 1 and k % 2 == 0
        draw_joints(sheet.add_subplot(grid[1 + k // 2, :] if wide else grid[1 + k // 2, k % 2]), record, samples, row)
    sheet.legend(loc="outside lower center", ncols=5, frameon=False, fontsize=7)
    return save(sheet, Path(path))


def draw_phase(axes: Any, record: Mapping[str, Any], samples: Mapping[str, Any]) -> None:
    """The phase plane."""
    shape = phase(record, samples)
    s, v = np.asarray(shape["s"], float), np.asarray(shape["v"], float)
    top = 1.5 * float(np.nanmax(v))
    second = "joint speeds and accelerations alone" if shape.get("kinematic") else "maximum velocity curve"
    for key, style, name in (("first", (0, (5, 3)), "joint speeds alone"), ("second", "solid", second)):
        curve = np.asarray(shape.get(key, [np.inf]), float)
        if np.nanmin(curve) < top:
            axes.plot(s, curve, color="#b3261e" if key == "second" else "#64717d", linestyle=style, linewidth=1.0, label=name)
            if key == "second":
                axes.fill_between(s, np.minimum(curve, 4 * top), 4 * top, color="#b3261e", alpha=0.07, linewidth=0)
    trials = [profile for row in listed(record.get("trials")) if isinstance(row, Mapping) and (profile := squared(row.get("profile")))]
    for k, (at, speed) in enumerate(trials):
        axes.plot(
            at,
            speed,
            color="#0a66a8",
            alpha=0.15 + 0.6 * k / max(1, len(trials) - 1),
            linewidth=0.8,
            label="trials" if k == len(trials) - 1 else None,
        )
    rows = stretches(record, samples)
    if not rows:
        axes.plot(s, v, color="#0a66a8", linewidth=1.8, label="the motion")
    for row in rows:
        kept = (s >= row["from"] - 1e-6) & (s <= row["to"] + 1e-6)
        axes.plot(s[kept], v[kept], color=ink(row["joint"]), linewidth=1.9, solid_capstyle="round")
    for k, name in enumerate(listed(record.get("joints"))):
        axes.plot([], [], color=ink(k), linewidth=1.9, label=str(name).replace("_", " ").removesuffix(" joint"))
    if oracle := squared(record.get("oracle")):
        axes.plot(*oracle, color="#17212b", linestyle=(0, (5, 3)), linewidth=1.2, label="true optimum")
    axes.set(xlim=(s[0], s[-1]), ylim=(0, top))
    dressed(axes, "along the path in rad", "path speed in rad/s")


def draw_joints(axes: Any, record: Mapping[str, Any], samples: Mapping[str, Any], row: tuple[str, str, str, str]) -> None:
    """One quantity of all joints: as shares of the limit, or in its unit where there is none."""
    key, limit, title, unit = row
    limits = record.get("limits")
    most = np.atleast_1d(vector(np.atleast_1d((limits if isinstance(limits, Mapping) else {}).get(limit) or []).tolist()))
    shares = len(most) > 0
    for k, values in enumerate(listed(samples[key])):
        scale = 100 / most[min(k, len(most) - 1)] if shares else 1.0
        axes.plot(samples["t"], np.asarray(values, float) * scale, color=ink(k), linewidth=0.9)
    if shares:
        for side in (-100, 100):
            axes.axhline(side, color="#b3261e", linestyle=(0, (3, 3)), linewidth=0.8)
    axes.set_xlim(0, samples["t"][-1])
    dressed(axes, "time in s", f"{title} in % of limit" if shares else f"{title} in {unit}")


def dressed(axes: Any, across: str, up: str) -> None:
    """Names of the axes, small, and no frame."""
    axes.set_xlabel(across, fontsize=8)
    axes.set_ylabel(up, fontsize=8)
    axes.tick_params(labelsize=7)
    axes.spines[["top", "right"]].set_visible(False)


def squared(value: Any) -> tuple[np.ndarray, np.ndarray] | None:
    """Place and path speed of a profile ``s, x``."""
    if not isinstance(value, Mapping):
        return None
    s, x = vector(value.get("s")), vector(value.get("x"))
    return (s, np.sqrt(np.maximum(x, 0.0))) if len(s) > 1 and len(s) == len(x) else None


def ink(joint: int | None) -> str:
    """The colour of a joint."""
    return "#55626f" if joint is None else JOINTS[joint % len(JOINTS)]
