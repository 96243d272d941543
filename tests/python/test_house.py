"""The import rule of the house: data flows one way, and so do imports."""

import ast
import re
from pathlib import Path

ROOT = Path(__file__).resolve().parents[2]
FLOORS = ["error", "context", "world", "path", "query", "timing", "certify", "optimize", "refine", "plan", "drive"]
EXTRA = {"arm": {"error", "path", "query", "timing"}, "optimize": {"error", "context"}}


def rust_imports():
    source = ROOT / "crates/guideway/src"
    for file in source.rglob("*.rs"):
        floor = file.relative_to(source).parts[0].removesuffix(".rs")
        if floor == "lib" or file.stem == "tests":
            continue
        text = re.split(r"#\[cfg\(test\)\]", file.read_text())[0]
        for name in re.findall(r"\bcrate::(\w+)", text):
            if name in FLOORS or name in EXTRA:
                yield file.relative_to(ROOT), floor, name


def test_rust_modules_only_see_the_floors_below():
    seen = 0
    for file, floor, name in rust_imports():
        seen += 1
        if floor == name:
            continue
        allowed = EXTRA.get(floor) or set(FLOORS[: FLOORS.index(floor)])
        assert name in allowed, f"{file}: {floor} may not see {name}"
    assert seen > 20


def python_imports(package):
    for file in (ROOT / "python/guideway").rglob("*.py"):
        parts = file.relative_to(ROOT / "python/guideway").parts
        if parts[0].removesuffix(".py") != package:
            continue
        for node in ast.walk(ast.parse(file.read_text())):
            if isinstance(node, ast.ImportFrom) and node.module:
                yield file.name, node.module
            elif isinstance(node, ast.Import):
                yield from ((file.name, alias.name) for alias in node.names)


def test_view_and_io_never_import_each_other():
    assert not [module for _, module in python_imports("view") if module.startswith("guideway.io")]
    assert not [module for _, module in python_imports("io") if module.startswith("guideway.view")]


def test_readers_and_pictures_do_not_touch_the_core():
    for package in ("view", "io"):
        assert not [module for _, module in python_imports(package) if module.startswith("guideway._core")]


def test_files_stay_short():
    files = [*(ROOT / "crates").rglob("*.rs"), *(ROOT / "python").rglob("*.py"), *(ROOT / "tests").rglob("*.py")]
    long = [str(file.relative_to(ROOT)) for file in files if "target" not in file.parts and len(file.read_text().splitlines()) > 500]
    assert not long, f"files over 500 lines: {long}"


def sources():
    for pattern in (
        "crates/**/*.rs",
        "benches/**/*.rs",
        "python/**/*.py",
        "tests/**/*.py",
        "benches/*.py",
        "examples/*.py",
        "fuzz/*.py",
        "experiments/**/*.py",
    ):
        yield from (file for file in ROOT.glob(pattern) if "target" not in file.parts)


def rust_functions(text):
    lines = text.splitlines()
    for i, line in enumerate(lines):
        head = re.match(r"(\s*)(?:pub(?:\([a-z]+\))? )?(?:const )?fn (\w+)", line)
        if head and not line.endswith(("}", ";")):
            end = next((k for k in range(i, len(lines)) if lines[k].startswith(head[1] + "}")), i)
            yield head[2], end - i + 1


def python_functions(text):
    for node in ast.walk(ast.parse(text)):
        if isinstance(node, (ast.FunctionDef, ast.AsyncFunctionDef)):
            yield node.name, (node.end_lineno or node.lineno) - node.lineno + 1


def test_functions_stay_short():
    found = [
        (file.name, name, count)
        for file in sources()
        for name, count in (rust_functions if file.suffix == ".rs" else python_functions)(file.read_text())
    ]
    assert len(found) > 500
    assert not [entry for entry in found if entry[2] > 60]


def test_nothing_is_left_over():
    marks = re.compile(
        r"\b(?:to" + r"do!|unimplemented!|TO" + r"DO|FIX" + r"ME|dbg!)|#\[(?:ignore|allow)\b|^\s*(?:breakpoint\(\)|import pdb)", re.MULTILINE
    )
    found = {
        str(file.relative_to(ROOT)): hit.group() for file in sources() if file != Path(__file__).resolve() and (hit := marks.search(file.read_text()))
    }
    assert not found


def test_every_cited_key_exists_and_every_source_is_cited():
    key = re.compile(r"(?<![\w-])[a-z]{2,}(?:19|20)\d{2}[a-z]*(?![\w-])")
    files = [*(ROOT / "crates").rglob("*.rs"), *(ROOT / "python").rglob("*.py")]
    cited = {name for file in files if "target" not in file.parts for name in key.findall(file.read_text())}
    entries = re.findall(r"^@\w+\{(\w+),(.*)$", (ROOT / "refs.bib").read_text(encoding="utf-8"), re.MULTILINE)
    known = {name for name, _ in entries}
    assert len(known) == len(entries) > 10
    assert cited == known, f"not in refs.bib: {sorted(cited - known)}; never cited: {sorted(known - cited)}"
    for name, fields in entries:
        assert all(f"{field}={{" in fields for field in ("author", "title", "year")), name
        assert name.endswith(re.findall(r"year=\{(\d{4})\}", fields)[0]), name
