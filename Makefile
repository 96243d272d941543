# `make demo` and `make test` set up everything they need in .venv/ from Python >= 3.10 and Rust alone.
PYTHON ?= python3
VENV := .venv
BIN := $(VENV)/bin
export PIP_DISABLE_PIP_VERSION_CHECK := 1
# Property tests draw the same cases every time; set another seed to look elsewhere.
export PROPTEST_RNG_SEED ?= 20261122
RUST_SOURCES := $(shell find crates -name '*.rs' -o -name Cargo.toml) Cargo.toml Cargo.lock pyproject.toml
PYTHON_SOURCES := $(shell find python -type f -not -name '*.so' -not -path '*/__pycache__/*')

# Files of tests are shared out between two processes.
PARALLEL := -n 2 --dist loadfile

.PHONY: demo test test-slow lint fmt bench results results-quick docs clean tools

demo: $(VENV)/.installed
	$(BIN)/guideway demo --out guideway-demo

test: $(VENV)/.tested
	cargo test --quiet --package guideway
	$(BIN)/python -m pytest -q $(PARALLEL) tests/python

test-slow: $(VENV)/.tested
	cargo test --release --package guideway --features slow
	$(BIN)/python -m pytest -q tests/python --run-slow

lint: $(VENV)/.tested
	cargo fmt --check
	cargo clippy --quiet --workspace --all-targets -- -D warnings
	$(BIN)/ruff format --check python tests benches examples experiments fuzz
	$(BIN)/ruff check python tests benches examples experiments fuzz
	$(BIN)/pyright --pythonpath $(BIN)/python

fmt: $(VENV)/.tested
	cargo fmt
	$(BIN)/ruff format python tests benches examples experiments fuzz
	$(BIN)/ruff check --fix python tests benches examples experiments fuzz

bench: $(VENV)/.tested
	$(BIN)/python -m pip install --quiet -c constraints.txt -r benches/requirements.txt
	$(BIN)/python benches/run.py

# Every experiment in its small version, and the report: at most ten minutes on two cores. `make results` is the whole: about two hours of CPU time. Both go on where they
# were stopped.
results-quick: $(VENV)/.results
	$(BIN)/guideway lab run all --quick --resume --out results/quick
	$(BIN)/guideway lab report results/quick --page results/quick/results.md

results: $(VENV)/.results
	$(BIN)/guideway lab run all --resume --out results/full
	$(BIN)/guideway lab report results/full --page docs/results.md

docs: $(VENV)/.installed
	cargo doc --no-deps --package guideway
	$(BIN)/python -m pip install --quiet -c constraints.txt pdoc
	$(BIN)/pdoc --output-directory docs/_build guideway
	@echo "Rust: target/doc/guideway/index.html   Python: docs/_build/index.html   Guides: docs/index.md"

tools:
	@command -v cargo >/dev/null || { echo "Guideway needs Rust (cargo) 1.88 or newer, and it is not on the PATH: install it with rustup, then run make again." >&2; exit 1; }
	@command -v $(PYTHON) >/dev/null || { echo "Guideway needs Python 3.10 or newer as '$(PYTHON)': install it, or call make PYTHON=/path/to/python3." >&2; exit 1; }
	@$(PYTHON) -c 'import sys, venv; sys.exit(sys.version_info < (3, 10))' || { echo "Guideway needs Python 3.10 or newer with the venv module; '$(PYTHON)' is not." >&2; exit 1; }

$(BIN)/python: | tools
	$(PYTHON) -m venv $(VENV)

# Every extra: about 2 GB, of which half comes with the libraries that the lab compares with (`peers`: VTK, Numba, faiss), and 240 MB are for statistics.
$(VENV)/.tested: EXTRAS := [arm,cluster,figures,lab,mujoco,peers,test,tune]
$(VENV)/.results: EXTRAS := [arm,cluster,lab,mujoco,peers,tune]
$(VENV)/.installed $(VENV)/.tested $(VENV)/.results: $(RUST_SOURCES) $(PYTHON_SOURCES) constraints.txt | $(BIN)/python
	@echo "Compiling Guideway into $(VENV): one to three minutes the first time."
	$(BIN)/python -m pip install --quiet -c constraints.txt '.$(EXTRAS)'
	@touch $(VENV)/.installed $@

clean:
	rm -rf $(VENV) target guideway-demo
