"""Shared fixtures: where the public data is, and whether slow tests run."""

import os
import shutil
from pathlib import Path

import pytest
from hypothesis import settings

from pages import markup

settings.register_profile("same", derandomize=True)
settings.load_profile("same")  # the same cases every time

ROOT = Path(__file__).resolve().parents[2]


def pytest_addoption(parser):
    parser.addoption("--run-slow", action="store_true", help="run long experiments too")


def pytest_collection_modifyitems(config, items):
    if not config.getoption("--run-slow"):
        chosen = [item for item in items if "slow" not in item.keywords]
        config.hook.pytest_deselected(items=[item for item in items if "slow" in item.keywords])
        items[:] = chosen


@pytest.fixture(scope="session")
def data() -> Path:
    """The folder of public maps and scenes; tests that need it are skipped without it."""
    for place in (os.environ.get("GUIDEWAY_DATA"), ROOT.parent / "shared" / "data"):
        if place and Path(place).is_dir():
            return Path(place)
    pytest.skip("public data not found (set GUIDEWAY_DATA)")


@pytest.fixture(scope="session")
def browser(tmp_path_factory: pytest.TempPathFactory) -> None:
    """Skips where no browser runs."""
    if shutil.which("chromium") is None or "<html" not in markup("about:blank", tmp_path_factory.mktemp("browser"))[0]:
        pytest.skip("no chromium that runs here")
