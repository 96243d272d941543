"""A short run of the fuzzer over every reader, with fixed seeds and counts."""

from __future__ import annotations

import importlib.util
import sys
from pathlib import Path
from types import ModuleType

import pytest


def fuzzer() -> ModuleType:
    path = Path(__file__).parents[2] / "fuzz" / "fuzz_io.py"
    spec = importlib.util.spec_from_file_location("fuzz_io", path)
    assert spec is not None
    assert spec.loader is not None
    module = importlib.util.module_from_spec(spec)
    sys.modules["fuzz_io"] = module
    spec.loader.exec_module(module)
    return module


FUZZ = fuzzer()
TARGETS = FUZZ.targets()


@pytest.mark.parametrize("name", sorted(TARGETS))
@pytest.mark.filterwarnings("ignore")
def test_every_answer_is_data_or_one_paragraph(name: str) -> None:
    count, failing = FUZZ.campaign(TARGETS[name], 20, lambda done: done < 250)
    assert failing is None, f"input {count} of seed 20: {failing!r}"


def test_the_fuzzer_finds_a_reader_that_breaks(monkeypatch: pytest.MonkeyPatch) -> None:
    import guideway.io

    def broken(path: str) -> None:
        if b"\xff\xfe" in Path(path).read_bytes():
            raise IndexError("not caught")

    monkeypatch.setitem(vars(guideway.io), "load", broken)
    _, failing = FUZZ.campaign(TARGETS["text"], 1, lambda done: done < 2000)
    assert failing is not None
    assert b"\xff\xfe" in failing
