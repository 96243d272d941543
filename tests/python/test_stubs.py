"""The type stubs say what the compiled core is."""

import subprocess
import sys

import pytest


def test_the_stubs_match_the_compiled_core(tmp_path):
    pytest.importorskip("mypy.stubtest")
    words = [sys.executable, "-m", "mypy.stubtest", "guideway._core", "--ignore-missing-stub"]
    done = subprocess.run(words, capture_output=True, text=True, cwd=tmp_path, timeout=600)
    assert done.returncode == 0, done.stdout + done.stderr


def test_every_public_name_exists():
    import guideway

    assert [name for name in guideway.__all__ if not hasattr(guideway, name)] == []
    assert guideway.__all__ == sorted(guideway.__all__)
