"""The tables of the drives, and the verdicts on what the source claims."""

from __future__ import annotations

import statistics
from collections.abc import Iterable
from typing import Any

import measures
import tables

Row = dict[str, Any]
LARGE = 0.64
"""A12 from which a difference counts."""


def calibrated(rows: list[Row]) -> float:
    """c_t: the tilt of the drives of plain DE then has the mean in print."""
    return measures.UNSMOOTHED / statistics.fmean(row["lean_mean"] for row in rows if row["error"] is None)


def mean(rows: Iterable[Row], key: str, scale: float = 1.0, digits: int = 2) -> str:
    """Mean and half-width of its 95 % interval."""
    values = [scale * row[key] for row in rows if row["error"] is None]
    if not values:
        return "-"
    middle, half = tables.interval(values)
    return f"{middle:.{digits}f}" if len(values) < 2 else f"{middle:.{digits}f} +- {half:.{digits}f}"


def rate(hits: int, count: int) -> str:
    low, high = tables.wilson(hits, count)
    return f"{hits}/{count} ({low:.2f}-{high:.2f})"


def drives(rows: list[Row], factor: float, methods: Iterable[str]) -> str:
    """A line per room, condition and method."""
    head = ["room", "condition", "method", "arrived", "success, 0.3 m", "0.25 m", "hits (unavoidable)", "TPE cm", "TTE cm", "path error cm", "time s"]
    head += ["peak jerk m/s3", "RMS jerk", "SSF", "ASF", "TS deg/m", "tilt deg", "Ms %", "PSI %", "TTEC J/m", "MOEC W h"]
    lines = []
    for key in dict.fromkeys((row["room"], row["condition"]) for row in rows):
        for method in methods:
            part = [row for row in rows if (row["room"], row["condition"]) == key and row["method"] == method]
            good = [row for row in part if row["error"] is None]
            if not good:
                lines.append([*key, method, f"0/{len(part)}", *["-"] * (len(head) - 4)])
                continue
            tilt = factor * statistics.fmean(row["lean_mean"] for row in good)
            index = statistics.fmean(measures.stability(factor * row["lean_rms"]) for row in good)
            arrived, safe, near = (sum(row.get(name) == want for row in good) for name, want in ARRIVED)
            hits = f"{sum(row['touched'] for row in good)} ({sum(row['unavoidable'] for row in good)})"
            lines.append([*key, method, f"{arrived}/{len(part)}", rate(safe, len(part)), f"{near}/{len(part)}", hits])
            lines[-1] += [mean(good, "tpe", 100), mean(good, "tte", 100), mean(good, "path_error", 100), mean(good, "time")]
            lines[-1] += [
                mean(good, "peak_jerk", digits=0),
                mean(good, "rms_jerk", digits=1),
                mean(good, "ssf", digits=1),
                mean(good, "asf", digits=1),
            ]
            lines[-1] += [mean(good, "ts", digits=1), f"{tilt:.2f}", f"{measures.stability(tilt):.1f}", f"{index:.1f}"]
            lines[-1] += [mean(good, "ttec", digits=1), mean(good, "moec", digits=2)]
    text = "Means with the half-width of their 95 % interval, success with its Wilson interval. "
    text += f"c_t = {factor:.3f}, from the drives of DE in the static w0.\n\n"
    return text + tables.markdown(head, lines)


ARRIVED = (("outcome", "arrived"), ("success", True), ("near_success", True))


def work(rows: list[Row], heap: list[Row], methods: Iterable[str]) -> str:
    """What planning takes: static w0."""
    lines = []
    for method in methods:
        good = [row for row in rows if (row["room"], row["condition"], row["method"]) == ("w0", "static", method) and row["error"] is None]
        size = next((row["mb"] for row in heap if row["method"] == method), None)
        if good:
            times = [row["plan_ms"] for row in good]
            lines.append([method, f"{statistics.median(times):.1f}", f"{statistics.fmean(row['evaluations'] for row in good):.0f}"])
            lines[-1] += ["-" if size is None else f"{size:.1f}", mean(good, "sptec"), mean(good, "tsec", digits=3)]
            lines[-1] += [
                mean(good, "length", digits=3),
                mean(good, "duration"),
                f"{sum(not row['ok'] for row in good)}",
                mean(good, "broken", digits=0),
            ]
    head = [
        "method",
        "CPU ms a plan",
        "evaluations",
        "memory MB",
        "SPTEC W s",
        "TSEC kW h",
        "length m",
        "duration s",
        "refused",
        "samples over a limit",
    ]
    return "Planning in the static w0.\n\n" + tables.markdown(head, lines)


def roc(rows: list[Row], methods: Iterable[str]) -> str:
    """AUC of the confidence, both rooms, dynamic."""
    lines = []
    for method in methods:
        scores = [tuple(score) for row in rows if row["method"] == method and row["condition"] == "dynamic" for score in row.get("scores", [])]
        found = measures.auc(scores)
        if found is None:
            lines.append([method, "-", "-", sum(free for _, free in scores), sum(not free for _, free in scores)])
        else:
            lines.append([method, f"{found[0]:.3f}", f"{found[1]:.3f}-{found[2]:.3f}", found[3], found[4]])
    return "Does the confidence foretell which segments stay free? Both rooms, dynamic.\n\n" + tables.markdown(
        ["method", "AUC", "DeLong 95 %", "positives", "negatives"], lines
    )


def said(holds: bool) -> str:
    return "holds" if holds else "does not hold"


def verdicts(rows: list[Row], searches: list[Row], loops: list[Row], methods: Iterable[str]) -> str:
    parts = [first(searches), second(rows), third(loops), fourth(rows, methods)]
    return "\n".join(parts)


def first(searches: list[Row]) -> str:
    """(i) IDE beats DE at equal evaluations on W0."""
    words, lines = [], []
    for budget in dict.fromkeys(row["budget"] for row in searches):
        part = [row for row in searches if row["budget"] == budget]
        de, ide = ([row for row in part if row["planner"] == name and row["error"] is None] for name in ("de", "improved-de"))
        for name in ("all", *dict.fromkeys(row["class"] for row in de + ide)):
            a, b = ([row["f"] for row in group if name in ("all", row["class"])] for group in (de, ide))
            cells = [f"{statistics.fmean(v):.4f} (best {min(v):.4f}, sd {statistics.pstdev(v):.4f})" if v else "-" for v in (a, b)]
            lines.append([budget, name, len(a), cells[0], len(b), cells[1], f"{tables.a12(b, a):.2f}" if a and b else "-"])
        paired = {row["seed"]: row["f"] for row in de}
        both = [(row["f"], paired[row["seed"]]) for row in ide if row["seed"] in paired]
        effect = tables.a12([row["f"] for row in ide], [row["f"] for row in de])
        p = tables.signed_rank([b[0] for b in both], [b[1] for b in both]) if both else 1.0
        nothing = sum(row["error"] is not None for row in part)
        words.append(f"{budget} evaluations: A12 {effect:.2f}, p {p:.2g}, {nothing} runs without a path: {said(effect > LARGE and p < 0.05)}")
    text = f"**(i) Improved DE beats DE at equal evaluations on w0** (A12 above {LARGE}). {'; '.join(words)}.\n\n"
    head = ["evaluations", "homotopy class", "DE runs", "DE, mean f", "improved DE runs", "improved DE, mean f", "A12"]
    return text + "By homotopy class (turns round each disc, against the straight line):\n\n" + tables.markdown(head, lines)


def compared(rows: list[Row], one: str, other: str, key: str) -> tuple[float, float]:
    """A12 that the other has more, and p of paired runs; static and dynamic and none together."""
    at = {(row["room"], row["condition"], row["seed"]): row[key] for row in rows if row["method"] == one and row["error"] is None}
    pairs = [
        (at[row["room"], row["condition"], row["seed"]], row[key])
        for row in rows
        if row["method"] == other and row["error"] is None and (row["room"], row["condition"], row["seed"]) in at
    ]
    if not pairs:
        return float("nan"), 1.0
    return tables.a12([a for a, _ in pairs], [b for _, b in pairs]), tables.signed_rank([a for a, _ in pairs], [b for _, b in pairs])


def second(rows: list[Row]) -> str:
    """(ii) A-I-DE has less jerk and tracking error than DE with the trapezoid."""
    names = {"peak_jerk": "peak jerk", "rms_jerk": "RMS jerk", "tte": "TTE"}
    found = {key: compared(rows, "A-I-DE", "DE", key) for key in names}
    ps = tables.holm([found[key][1] for key in names])
    lines = [f"{names[key]} A12 {found[key][0]:.2f}, p {p:.2g}" for key, p in zip(names, ps, strict=True)]
    holds = all(found[key][0] > 0.5 and p < 0.05 for key, p in zip(names, ps, strict=True))
    return (
        f"**(ii) A-I-DE has lower peak and RMS jerk and lower TTE than DE with the trapezoid** (same tracker): {'; '.join(lines)}: {said(holds)}.\n"
    )


def third(loops: list[Row]) -> str:
    """(iii) the closed loop removes all overspeed regions."""
    lines, good = [], True
    for room in dict.fromkeys(row["room"] for row in loops):
        part = [row for row in loops if row["room"] == room]
        done = [row for row in part if row["error"] is None]
        clean = sum(row["left"] == 0 for row in done)
        good &= clean == len(part) and not any(row["broken"] for row in done)
        found, broken = sum(row["found"] for row in done), sum(row["broken"] for row in done)
        slow = max((row["slower"] for row in done), default=float("nan"))
        early = [row for row in done if row["early"] is not None]
        with_regions, left = sum(row["early"] > 0 for row in early), sum(row["early_left"] > 0 for row in early)
        good &= left == 0
        lines.append([room, len(part), found, f"{clean}/{len(part)}", broken, f"{sum(row['ok'] for row in done)}/{len(part)}", f"{slow:.3f}"])
        lines[-1] += [f"{with_regions}/{len(early)}", f"{left}/{len(early)}"]
    head = [
        "room",
        "runs",
        "regions found",
        "runs without one at the end",
        "samples over a limit at 1 kHz",
        "certified",
        "slowest against time-optimal",
        "early DE paths with regions",
        "with regions after correction",
    ]
    return f"**(iii) The closed loop removes all overspeed regions**: {said(good)}.\n\n" + tables.markdown(head, lines)


def fourth(rows: list[Row], methods: Iterable[str]) -> str:
    """(iv) the order of TTE."""
    pairs = [("A-I-DE", "IASCV"), ("A-I-DE", "DE"), ("IASCV", "ACO"), ("IASCV", "FA"), ("DE", "ACO"), ("DE", "FA")]
    found = [compared(rows, one, other, "tte") for one, other in pairs]
    ps = tables.holm([p for _, p in found])
    lines = [
        [f"{a} < {b}", f"{effect:.2f}", f"{p:.2g}", said(effect > 0.5 and p < 0.05)] for (a, b), (effect, _), p in zip(pairs, found, ps, strict=True)
    ]
    holds = all(line[-1] == "holds" for line in lines)
    order = sorted(methods, key=lambda m: statistics.fmean([row["tte"] for row in rows if row["method"] == m and row["error"] is None] or [9e9]))
    words = f"**(iv) TTE: A-I-DE < IASCV, DE < ACO, FA**: {said(holds)}. Mean TTE over all runs, ascending: {', '.join(order)}.\n\n"
    return words + tables.markdown(["pair", "A12", "p after Holm", ""], lines)
