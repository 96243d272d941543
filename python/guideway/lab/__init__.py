"""The lab: experiments as data, run on one machine or a cluster, judged with honest statistics.

An experiment is a TOML file: worlds, queries, methods, seeds, budget, the figures in print and what their source claims. ``guideway lab run`` makes
one record per (world, query, method, seed), ``guideway lab report`` tables and pictures of them.
"""

from __future__ import annotations

from guideway.lab.comparing import Comparison, compare
from guideway.lab.coordinator import run, told
from guideway.lab.experiment import Claim, Experiment, Metric, Published, Run
from guideway.lab.kinds import KINDS, Outcome
from guideway.lab.packaged import experiments, packaged
from guideway.lab.reading import quick, read, with_seeds
from guideway.lab.tuning import tune

__all__ = [
    "KINDS",
    "Claim",
    "Comparison",
    "Experiment",
    "Metric",
    "Outcome",
    "Published",
    "Run",
    "compare",
    "experiments",
    "packaged",
    "quick",
    "read",
    "run",
    "told",
    "tune",
    "with_seeds",
]
