"""The figures in print: those of the experiment files beside a copy that was typed from the sources on its own."""

from __future__ import annotations

import csv
from pathlib import Path

import pytest

from guideway.lab import packaged, read

COPY = Path(__file__).resolve().parents[1] / "data/published.csv"
Figure = tuple[str, str, str, str, str, str]


def copied() -> dict[str, dict[Figure, float]]:
    """Experiment -> (table, world, query, method, metric, statistic) -> value."""
    found: dict[str, dict[Figure, float]] = {}
    with COPY.open(encoding="utf-8", newline="") as file:
        for row in csv.DictReader(file):
            key = (row["table"], row["world"], row["query"], row["method"], row["metric"], row["statistic"])
            figures = found.setdefault(row["experiment"], {})
            assert key not in figures, f"{key} is there twice"
            figures[key] = float(row["value"])
    return found


@pytest.mark.parametrize("name", packaged())
def test_figures_of_a_file_are_those_of_the_copy(name) -> None:
    experiment = read(packaged()[name], check=False)
    figures = {(p.table, p.world, p.query, p.method, p.metric, p.statistic): p.value for p in experiment.published}
    assert len(figures) == len(experiment.published)
    assert figures == copied().get(name, {})


def test_every_figure_is_in_a_file() -> None:
    assert set(copied()) <= set(packaged())


def test_claims_of_a_source_name_where_they_stand() -> None:
    for name, path in packaged().items():
        experiment = read(path, check=False)
        assert experiment.name == name
        if experiment.published:
            assert any(claim.table for claim in experiment.claims), name
        for claim in experiment.claims:
            assert claim.test != "none" or len(claim.reason) > 20
