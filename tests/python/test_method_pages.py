"""The method pages agree with the registry: names, defaults and paper settings of every parameter, pictures and links that exist."""

import json
import re
from pathlib import Path

import pytest

import guideway as gw

PAGES = Path(__file__).resolve().parents[2] / "docs" / "methods"
ENTRIES = {entry["name"]: entry for entry in gw.planners()}
NAMED = [name for name in ENTRIES if (PAGES / f"{name}.md").exists()]


def rows(text):
    """(names, default, paper) of each row of the parameter tables."""
    for table in re.findall(r"^\| parameter \|(.*\n(?:\|.*\n)+)", text, re.MULTILINE):
        head, _, *lines = table.splitlines()
        shared = head.strip().startswith("default and paper")
        for line in lines:
            cells = [cell.strip() for cell in line.strip("|").split("|")]
            paper = cells[1] if shared or cells[2] == "same" else cells[2]
            yield re.findall(r"`(\w+)`", cells[0]), cells[1], paper


def values(text):
    """The numbers and words of a cell, in order: lists are flat, units and remarks are left out."""
    text = re.sub(r"\([^)]*\)", "", text.replace("`", ""))
    parts = [part.strip() for part in re.split(r",| to |\[|\]", text) if part.strip()]
    return [part for part in (re.match(r"[\w.-]+", part) for part in parts) if part]


def expected(value):
    flat = value if isinstance(value, list) else [value]
    return [json.dumps(item) if not isinstance(item, str) else item for item in flat]


def same(found, wanted):
    try:
        return float(found) == float(wanted)
    except ValueError:
        return found == wanted


@pytest.mark.parametrize("name", NAMED)
def test_tables_agree_with_the_registry(name):
    entry = ENTRIES[name]
    defaults = {parameter["name"]: parameter["default"] for parameter in entry["parameters"]}
    seen = 0
    for names, default, paper in rows((PAGES / f"{name}.md").read_text(encoding="utf-8")):
        assert set(names) <= set(defaults), f"{name}: no such parameter in {names}"
        for cell, table in ((default, defaults), (paper, entry["paper"] or defaults)):
            wanted = [item for key in names for item in expected(table[key])]
            found = [part.group() for part in values(cell)][: len(wanted)]
            found = found * len(wanted) if len(found) == 1 else found  # one for all
            assert len(found) == len(wanted), f"{name}: {names} = {cell}, registry {wanted}"
            assert all(map(same, found, wanted)), f"{name}: {names} = {cell}, registry {wanted}"
        seen += len(names)
    assert seen > 3


@pytest.mark.parametrize("name", NAMED)
def test_every_parameter_is_explained(name):
    text = (PAGES / f"{name}.md").read_text(encoding="utf-8")
    linked = [(PAGES / page).read_text(encoding="utf-8") for page in re.findall(r"\]\(([\w-]+\.md)\)", text)]
    missing = [
        p["name"] for p in ENTRIES[name]["parameters"] if not any(f"`{p['name']}`" in page or f"{p['name']}=" in page for page in [text, *linked])
    ]
    assert not missing


def test_every_method_has_a_page_with_a_picture_and_its_limits():
    heuristics = {name for name, entry in ENTRIES.items() if entry["paper"] is not None}
    assert heuristics <= set(NAMED)
    for name in sorted(heuristics):
        text = (PAGES / f"{name}.md").read_text(encoding="utf-8")
        assert f"(../pictures/method-{name}.png)" in text, name
        assert "## When to use it" in text, name
    index = (PAGES / "index.md").read_text(encoding="utf-8")
    for page in PAGES.glob("*.md"):
        assert page.stem == "index" or f"({page.name})" in index, page.name


def test_links_and_pictures_exist():
    docs = PAGES.parent
    for page in [*docs.glob("*.md"), *PAGES.glob("*.md"), docs.parent / "README.md"]:
        for target in re.findall(r"\]\(([^)#\s]+)(?:#[^)]*)?\)", page.read_text(encoding="utf-8")):
            if "://" not in target:
                assert (page.parent / target).exists(), f"{page.name}: {target}"
