"""Jerk-limited motions beside trapezoidal ones of the same path, driven by a base simulated in MuJoCo: tilt, slip, contacts, tracking, energy.

python experiments/driving/physics.py [--seeds 10] [--heights 0.2 0.3] [--docs]
"""

from __future__ import annotations

import argparse
import math
import sys
from collections.abc import Iterable
from dataclasses import replace
from itertools import product
from pathlib import Path
from typing import Any

import numpy as np
from tqdm import tqdm

sys.path.insert(0, str(Path(__file__).resolve().parents[1]))
import tables

import guideway as gw
from guideway.lab import statistics
from guideway.plants import MobileBase, Settings, film

Row = dict[str, Any]
ROOMS = ("w0", "layouts")
"""The room of the source, and random layouts of it, one a seed."""
MOTIONS = ("A-I-DE", "trapezoid", "trapezoid, as slow")
"""As planned; without a limit of jerk on the same path; the same with the acceleration that makes it last as long as the first."""
HELD = ("limited jerk, held", "trapezoid, held")
"""On the same path within what the base says that it can hold, as `guideway drive` does it."""
MEASURES = {
    "time": ("time s", 2),
    "tilt_max": ("tilt max deg", 2),
    "tilt_mean": ("mean deg", 2),
    "tilt_rms": ("RMS deg", 2),
    "psi": ("PSI %", 1),
    "ms": ("Ms %", 1),
    "tte": ("TTE cm", 2),
    "tpe": ("TPE cm", 2),
    "slip_rms": ("slip RMS cm/s", 1),
    "slip_max": ("max cm/s", 1),
    "work": ("wheel work J", 0),
    "ttec": ("TTEC J/m", 1),
}
TESTED = ("tilt_max", "tilt_rms", "tte", "slip_max", "work")
PICTURE = Path(__file__).resolve().parents[2] / "docs/pictures/mujoco-room.png"


def motions(found: gw.Solution, limits: gw.Limits) -> dict[str, gw.Trajectory]:
    """The three motions of a plan."""
    own = found.trajectory
    assert own is not None
    low, high = 0.1, limits.acceleration
    for _ in range(40):
        middle = 0.5 * (low + high)
        slow = gw.time(found.path, replace(limits, acceleration=middle, deceleration=middle), method="trapezoid")
        low, high = (middle, high) if slow.duration > own.duration else (low, middle)
    gentle = gw.time(found.path, replace(limits, acceleration=high, deceleration=high), method="trapezoid")
    return dict(zip(MOTIONS, (own, gw.time(found.path, limits, method="trapezoid"), gentle), strict=True))


def held(query: gw.Query, found: gw.Solution, limits: gw.Limits, height: float) -> dict[str, gw.Trajectory]:
    """The motions within what the base can hold."""
    own = found.trajectory
    assert own is not None
    most = MobileBase(query, own, settings=Settings(height=height)).limits
    asked = limits.to_dict()
    limits = replace(limits, **{name: min(value, math.inf if asked[name] is None else asked[name]) for name, value in most.items()})
    return dict(zip(HELD, (gw.time(found.path, limits), gw.time(found.path, limits, method="trapezoid")), strict=True))


def driven(query: gw.Query, motion: gw.Trajectory, seed: int, height: float, limits: gw.Limits) -> Row:
    """A drive as it is asked for and what was measured of it. The plant has the limits of the robot, whatever those of the motion."""
    plant = MobileBase(query, motion, seed=seed, settings=Settings(height=height, margin=0.0), limits=limits)
    run = gw.drive(query, motion, "tracker", seed=seed, plant=plant, time_limit=30.0)
    found = run["plant"]
    return {
        "outcome": run["outcome"],
        "contacts": found["contacts"],
        "planned": motion.duration,
        "peak": float(np.abs(motion.sample(200.0)[:, 5]).max()),
        "time": run["time"],
        "tte": 100 * run["tracking"]["tte"],
        "tpe": 100 * run["tracking"]["tpe"],
        "ttec": run["energy"]["ttec"],
        "work": found["energy"]["work"],
        "slip_rms": 100 * found["slip"]["rms"],
        "slip_max": 100 * found["slip"]["max"],
        "psi": found["tilt"]["psi"],
        "ms": found["tilt"]["ms"],
        **{f"tilt_{key}": found["tilt"][key] for key in ("max", "mean", "rms")},
    }


def collect(seeds: int, heights: Iterable[float]) -> list[Row]:
    """All drives, a row each."""
    rows = []
    for room in tqdm(ROOMS, desc="rooms", disable=None):
        for seed in tqdm(range(seeds), desc=room, leave=False, disable=None):
            scene = gw.scenes.layout(seed) if room == "layouts" else gw.scenes.load("w0", seed)
            query = scene.query("static")
            found = gw.plan(query, "aide", seed=seed)
            asked = motions(found, scene.limits)
            for height in heights:
                for name, motion in (asked | held(query, found, scene.limits, height)).items():
                    row = driven(query, motion, seed, height, scene.limits if name in asked else gw.Limits(**motion.limits))
                    rows.append({"room": room, "height": height, "motion": name, "seed": seed} | row)
    return rows


def table(rows: list[Row], heights: Iterable[float]) -> str:
    """Means with the half-widths of their 95 % intervals."""
    lines = []
    for room in ROOMS:
        for height in heights:
            for name in MOTIONS + HELD:
                own = [row for row in rows if (row["room"], row["height"], row["motion"]) == (room, height, name)]
                arrived = sum(row["outcome"] == "arrived" for row in own)
                touched = sum(row["contacts"] > 0 for row in own)
                cells = []
                for key, (_, digits) in MEASURES.items():
                    found = statistics.describe([row[key] for row in own])
                    cells.append("-" if found.high is None else f"{found.mean:.{digits}f} ± {found.high - found.mean:.{digits}f}")
                planned, peak = (np.mean([row[key] for row in own]) for key in ("planned", "peak"))
                lines.append([f"`{room}`", f"{height:g}", name, f"{arrived}/{len(own)}", f"{touched}", f"{planned:.2f}", f"{peak:.2f}", *cells])
    head = ["room", "c. of g. m", "motion", "arrived", "touched", "planned s", "peak m/s2", *(words for words, _ in MEASURES.values())]
    return tables.markdown(head, lines)


def comparisons(rows: list[Row], heights: Iterable[float]) -> str:
    """Each trapezoid against the jerk-limited motion on the same paths, seed by seed: A12, and p after Holm over those of one motion."""
    lines = []
    for room, height, (first, *others) in product(ROOMS, heights, (MOTIONS, HELD)):
        of = {
            name: {key: [row[key] for row in rows if (row["room"], row["height"], row["motion"]) == (room, height, name)] for key in TESTED}
            for name in (first, *others)
        }
        found = {key: [statistics.paired(of[first][key], of[name][key]) for name in others] for key in TESTED}
        ps = {key: statistics.holm([each.p for each in found[key]]) for key in TESTED}
        for k, name in enumerate(others):
            cells = [f"{found[key][k].a12:.2f} ({ps[key][k]:.2g})" for key in TESTED]
            lines.append([f"`{room}`", f"{height:g}", first, name, *cells])
    return tables.markdown(["room", "c. of g. m", "motion", "against", "tilt max", "tilt RMS", "TTE", "slip max", "wheel work"], lines)


def picture() -> str:
    """The room with a drive of A-I-DE."""
    scene = gw.scenes.load("w0")
    query = scene.query("static")
    motion = gw.plan(query, "aide", seed=0).trajectory
    assert motion is not None
    plant = MobileBase(query, motion)
    gw.drive(query, motion, "tracker", plant=plant)
    try:
        film.save(plant, PICTURE, size=(1000, 625))
    except film.NoPicture as error:
        return f"no picture: {error}"
    return f"wrote {PICTURE}"


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--seeds", type=int, default=10, help="seeds (%(default)s)")
    parser.add_argument("--heights", type=float, nargs="+", default=[0.2, 0.3], help="heights of the centre of gravity, m (%(default)s)")
    parser.add_argument("--out", type=Path, default=Path("experiments/results/driving"), help="folder of tables (%(default)s)")
    parser.add_argument("--docs", action="store_true", help="put the tables into docs/experiments.md, and the picture beside them")
    given = parser.parse_args()
    rows = collect(given.seeds, given.heights)
    given.out.mkdir(parents=True, exist_ok=True)
    tables.write_csv(given.out / "physics.csv", rows)
    text = (
        table(rows, given.heights)
        + "\nThe motions of limited jerk beside the others on the same paths and seeds (A12, above 0.5 where the other has the larger values, and in "
        "brackets p of Wilcoxon signed ranks after Holm over the others of one motion):\n\n" + comparisons(rows, given.heights)
    )
    words = f"--seeds {given.seeds} --heights {' '.join(f'{h:g}' for h in given.heights)} --docs"
    tables.publish("physics", f"python experiments/driving/physics.py {words}", text, given.out, given.docs)
    if given.docs:
        print(picture())


if __name__ == "__main__":
    main()
