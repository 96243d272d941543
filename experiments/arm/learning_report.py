"""Tables of velocity self-learning from the runs' records."""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Callable
from typing import Any

import numpy as np
import tables
from scipy import stats

Row = dict[str, Any]


def grouped(rows: list[Row], *names: str) -> dict[tuple[Any, ...], list[Row]]:
    found: dict[tuple[Any, ...], list[Row]] = defaultdict(list)
    for row in rows:
        found[tuple(str(row["key"].get(name, "")) for name in names)].append(row)
    return found


def spread(values: list[float], digits: int = 3) -> str:
    """Median and range."""
    low, middle, high = np.min(values), np.median(values), np.max(values)
    return f"{middle:.{digits}f}" if high - low < 0.5 * 10**-digits else f"{middle:.{digits}f} ({low:.{digits}f} to {high:.{digits}f})"


def methods(rows: list[Row]) -> str:
    lines = []
    order = list(dict.fromkeys(row["key"]["learner"] for row in rows))
    for (payload, learner), runs in sorted(grouped(rows, "payload", "learner").items(), key=lambda pair: (pair[0][0], order.index(pair[0][1]))):
        ended = [row for row in runs if "error" not in row]
        if not ended:
            lines.append((payload, f"`{learner}`", "-", runs[0]["error"][:60], "", "", "", ""))
            continue
        last, clean = [row["rows"][-1] for row in ended], [row["clean"] for row in ended if row["clean"]]
        first = spread([found[0] for found in clean], 0) if clean else "never"
        fastest = f"{spread([found[2] for found in clean])} ({spread([found[1] for found in clean], 0)})" if clean else "-"
        cells = (spread([row["count"] for row in ended], 0), first, fastest, spread([r[0] for r in last]), spread([100 * r[1] for r in last], 1))
        lines.append((payload, f"`{learner}`", *cells, spread([r[2] for r in last])))
    head = (
        "payload kg",
        "learner",
        "trials",
        "first clean trial",
        "T/T* of the fastest clean one (which)",
        "T/T* of the last",
        "its true violation %",
    )
    text = tables.markdown((*head, "its time over limit s"), lines)
    notes = "Noise 0.5 and 0.15 N m; clean is without a measured violation; violations below 0 are inside the limits."
    return f"{text}\n{notes} `rl` was stopped after 500 trials.\n"


def source(rows: list[Row]) -> str:
    lines = []
    for (payload, _, noise), runs in grouped(rows, "payload", "settings", "noise").items():
        ended = [row for row in runs if "error" not in row]
        last = [row["rows"][-1] for row in ended]
        feasible = sum(row["finished"] and row["count"] < 40 and r[1] <= 0 for row, r in zip(ended, last, strict=True))
        given = runs[0]["key"]["settings"]
        cells = (payload, noise or "0.5", given["segments"], given["step"], given["reading"], f"{feasible} of {len(runs)}")
        ratios = (spread([r["rows"][0][0] for r in ended]), spread([r[0] for r in last]), spread([100 * r[1] for r in last], 1))
        lines.append((*cells, spread([row["count"] for row in ended], 0), *ratios))
    head = ("payload kg", "noise", "c", "d", "reading", "feasible", "trials", "T/T* at the start", "at the end", "true violation % at the end")
    return tables.markdown(head, lines) + "\nWithout noise the margin is 0, with noise 3 %.\n"


def targets(rows: list[Row]) -> str:
    lines = []
    for (payload, noise), runs in sorted(grouped(rows, "payload", "noise").items()):
        all_ = np.array([row["rows"] for row in runs], float)
        ratio, true = all_[:, :, 0], all_[:, :, 1]
        met = (f"{(ratio[:, 3] <= 1.05).sum()}", f"{(ratio[:, 5] <= 1.03).sum()}", f"{(true[:, 2:] <= 0.01).all(1).sum()}")
        trials = tuple(spread(ratio[:, k].tolist()) for k in (1, 3, 5))
        lines.append((payload, noise, len(runs), *trials, *met, f"{100 * true[:, 1:].max():.2f}", f"{all_[:, :, 6].max():.3f}"))
    head = ("payload kg", "noise N m", "seeds", "T/T* trial 2", "trial 4", "trial 6", "<= 1.05 by 4", "<= 1.03 by 6", "true <= 1 % from trial 3")
    return tables.markdown((*head, "largest true violation %, trials 2 to 6", "largest lower bound / T*"), lines)


def random(rows: list[Row]) -> str:
    used, errors = [row for row in rows if "error" not in row], [row for row in rows if "error" in row]
    refused = sum(row["refused"] for row in used)
    lines = []
    for name, some in (("reference", [r for r in used if not r["full"]]), ("full", [r for r in used if r["full"]]), ("both", used)):
        if not some:
            continue
        true = np.array([trial[1] for row in some for trial in row["rows"][1:]])
        judged = [row for row in some if np.isfinite(row["oracle"])]
        beyond, count = int((true > 0.01).sum()), true.size
        ratio = [row["rows"][3][0] / row["oracle"] for row in judged]
        quantiles = ", ".join(f"{q:.3f}" for q in np.quantile(ratio, (0.5, 0.9, 1.0)))
        most = float(stats.beta.ppf(0.95, beyond + 1, count - beyond))
        cells = (name, len(some), count, int((true > 0).sum()), beyond, f"{1000 * most:.2f}", f"{100 * true.max():.2f}")
        lines.append((*cells, f"{quantiles} ({len(judged)})"))
    head = (
        "friction",
        "plants",
        "learned trials",
        "beyond a limit",
        "by more than 1 %",
        "that is at most, in 1000 (95 %)",
        "largest true violation %",
    )
    text = tables.markdown((*head, "T/T* of trial 4: median, 90 %, worst (plants)"), lines)
    text += (
        f"\n{len(errors)} plants ended in an error. {refused} more had been drawn that cannot hold and rub slowly on the path within 98 % of their"
    )
    return text + " limits: others took their place. The one-sided bound is Clopper's and Pearson's.\n"


def mujoco(rows: list[Row]) -> str:
    lines = []
    for (robot, payload, _, friction, fed), runs in grouped(rows, "robot", "payload", "at", "friction", "feedforward").items():
        where = "on the axis" if runs[0]["key"]["at"][0] == 0 else "beside it"
        good = [row for row in runs if "error" not in row]
        if not good:
            lines.append((robot, payload, where, friction, fed, len(runs), runs[0]["error"][:80], "", "", "", "", "", "", ""))
            continue
        all_ = np.array([row["rows"] for row in good], float)
        cells = [spread(all_[:, k, 0].tolist()) for k in (1, 3, 5)]
        clean = [spread([min((r[k] for r in row["rows"] if r[4]), default=np.nan) for row in good]) for k in (0, 7)]
        worst = f"{100 * all_[:, 1, 1].max():.1f}, {100 * all_[:, 2:, 1].max():.1f}"
        price = f"{100 * (np.median([row['price'] for row in good]) - 1):.1f}"
        lines.append((robot, payload, where, friction, fed, len(runs), *cells, *clean, worst, f"{all_[:, 2:, 2].max():.3f}", price))
    head = ("robot", "payload kg", "centre", "friction", "fed forward", "seeds", "T/T* trial 2", "trial 4", "trial 6")
    best = ("fastest without a measured violation", "the same, T* after the last trial")
    more = ("largest true violation %, trial 2, trials 3 to 6", "time over limit s, trials 3 to 6", "1 % of torque costs % of T*")
    notes = "T* is the optimum of the true plant in that trial, followed exactly: `full` friction falls by 0.33 % a trial. Beside the axis is"
    return tables.markdown((*head, *best, *more), lines) + (
        f"\n{notes} (0.03, 0.02, 0.08) m. The IRB 6700 has estimated masses; 150 kg of its payload are known.\n"
    )


TEXTS: dict[str, Callable[[list[Row]], str]] = {"methods": methods, "source": source, "targets": targets, "random": random, "mujoco": mujoco}
