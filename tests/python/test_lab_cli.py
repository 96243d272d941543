"""The verbs of the lab, and the experiments that ship."""

import json
import re
from pathlib import Path

import pytest

from guideway import lab
from guideway.cli import main

ROOT = Path(__file__).resolve().parents[2]

SMALL = """
schema = 1
name = "small"
kind = "plan"
seeds = 2
[[worlds]]
name = "one"
source = "scene:m20"
[[methods]]
name = "astar"
planner = "astar"
[quick]
seeds = 1
"""


def test_what_ships_is_what_lies_in_experiments():
    assert list(lab.packaged()) == sorted(path.stem for path in (ROOT / "experiments").glob("*.toml"))
    assert all(lab.read(path, check=False).name == name for name, path in lab.packaged().items())


def test_list(capsys):
    assert main(["lab", "list"]) == 0
    assert len(capsys.readouterr().out.splitlines()) == len(lab.packaged())
    assert main(["lab", "list", "--json"]) == 0
    rows = json.loads(capsys.readouterr().out)
    assert [row["name"] for row in rows] == list(lab.packaged())
    assert all(row["runs"] >= 1 and row["methods"] and row["worlds"] for row in rows)


def test_run_and_report(tmp_path, capsys):
    path = tmp_path / "small.toml"
    path.write_text(SMALL)
    out = str(tmp_path / "out")
    assert main(["lab", "run", str(path), "--out", out, "--workers", "1", "--quick"]) == 0
    assert "small: 1 record, 1 ok" in capsys.readouterr().out
    assert main(["lab", "run", str(path), "--out", out, "--workers", "1", "--resume"]) == 0
    assert "small: 2 records, 2 ok" in capsys.readouterr().out
    assert main(["lab", "report", out, "--no-figures"]) == 0
    assert "small" in (tmp_path / "out" / "report.html").read_text()


@pytest.mark.parametrize(
    ("words", "told"),
    [
        (["run", "nothing"], "guideway lab list"),
        (["run", "nothing.toml"], "nothing.toml"),
        (["run", "{small}", "--workers", "0"], "1 to 1024"),
        (["run", "{small}", "--seeds", "0"], "1 to 100000"),
        (["run", "{small}", "{again}"], "two of the experiments have the name 'small'"),
        (["run", "{small}", "--out", "{small}"], "small.toml"),
        (["run", "{small}", "--cluster", "ray://here"], "dask://HOST:PORT"),
        (["tune", "{small}"], "[tune]"),
        (["tune", "{small}", "--trials", "0"], "1 to 100000"),
        (["report", "{nowhere}"], "nowhere"),
        (["lay"], "invalid choice"),
    ],
)
def test_bad_words_are_told_of_in_one_paragraph(tmp_path, capsys, words, told):
    pytest.importorskip("distributed")
    for name in ("small", "again"):
        (tmp_path / f"{name}.toml").write_text(SMALL)
    places = {name: str(tmp_path / f"{name}.toml") for name in ("small", "again")} | {"nowhere": str(tmp_path / "nowhere")}
    out = [] if "--out" in words or words[0] in ("report", "lay") else ["--out", str(tmp_path / "out")]
    assert main(["lab", *(word.format(**places) for word in words), *out]) == 2
    said = " ".join(capsys.readouterr().err.split())
    assert re.sub(r"\s", "", told) in re.sub(r"\s", "", said)
    assert "Traceback" not in said
