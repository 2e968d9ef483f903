# `make reproduce` and `make test` need a Rust toolchain, Python >= 3.10 and make; everything else they install
# themselves, into .venv and target. Times in the messages are rough ones, of two idle cores.

PYTHON ?= python3
VENV := .venv
BIN := $(VENV)/bin
OUT ?= out
WHEELS := target/wheels
INSTALLED := $(VENV)/.installed
DOCS_INSTALLED := $(VENV)/.docs-installed
SOURCES := Cargo.toml Cargo.lock pyproject.toml README.md $(shell find src python -name '*.rs' -o -name '*.py' -o -name '*.pyi')
# Printed before each step: what it does and roughly how long it takes.
SAY := @printf '\n=== %s\n'
PIP := $(BIN)/python -m pip install --disable-pip-version-check

.PHONY: help reproduce report test test-rust test-python test-minimal test-torch lint licences fuzz leak interrupts bench benchmark gallery boundary boundary-cost control-points accuracy study paper-map stub doc docs check-docs wheels clean

help: ## Show this list
	@grep -E '^[a-z-]+:.*##' $(MAKEFILE_LIST) | sed -E 's/:[^#]*## /\t/' | sort | expand -t 16

$(BIN)/python:
	@$(PYTHON) -c 'import sys; sys.exit(sys.version_info < (3, 10))' || { \
		echo "Python >= 3.10 is needed; '$(PYTHON)' is $$($(PYTHON) --version). Say make PYTHON=..." >&2; exit 1; }
	$(SAY) 'Virtual environment in $(VENV) (10 seconds)'
	$(PYTHON) -m venv $(VENV)

# Call maturin directly: pip hides the progress of cargo. The last command finds the package installed and adds its dependencies.
$(INSTALLED): $(BIN)/python $(SOURCES)
	$(SAY) 'Compile the Python module (10 minutes the first time; the last crate, stiefel-rs, takes most of them)'
	$(PIP) --quiet 'maturin>=1.9.4,<2'
	rm -f $(WHEELS)/stiefel_rs-*.whl
	$(BIN)/maturin build --release --locked --compatibility off --interpreter $(BIN)/python --out $(WHEELS)
	$(SAY) 'Install it with the packages for tests (minutes the first time)'
	$(PIP) --force-reinstall --no-deps $(WHEELS)/stiefel_rs-*.whl
	$(PIP) 'stiefel-rs[plot,test]'
	@touch $@

reproduce: $(INSTALLED) ## The paper's statements, tables and figures, recomputed, into out/
	$(SAY) 'Recompute the paper into $(OUT) (with a progress bar)'
	$(BIN)/stiefel-rs reproduce --out $(OUT)

report: $(INSTALLED) ## The same and a report of a few pages, out/report.pdf
	$(SAY) 'Recompute the paper into $(OUT), with a report (with a progress bar)'
	$(PIP) --quiet 'stiefel-rs[report]'
	$(BIN)/stiefel-rs reproduce --report --out $(OUT)

test: test-rust test-python ## All tests of both languages

test-rust: ## Unit, integration and documentation tests of the crate
	$(SAY) 'Tests of the crate (minutes to compile the first time)'
	cargo test --locked --features serde

test-python: $(INSTALLED) ## The Python tests, stubs among them, and types
	$(SAY) 'Python tests (about 10 minutes, on all cores); missing tools are listed at the end, one per line'
	$(BIN)/python -m pytest --numprocesses auto --maxprocesses 8 --dist loadfile
	$(SAY) 'Types'
	$(BIN)/python -m mypy

MINIMAL_TESTS := $(addprefix tests/python/test_, readme.py curves.py stiefel.py splines.py spline_input.py velocities.py save.py interpolate.py \
	threads.py)

test-minimal: ## Tests for the oldest packages, with those that are installed: pip install -c tests/python/minimal.txt
	$(PYTHON) -m pytest $(MINIMAL_TESTS)

test-torch: $(INSTALLED) ## The tests of stiefel_rs.torch; installs PyTorch, which is gigabytes
	$(SAY) 'Install PyTorch (gigabytes the first time), and run its tests'
	$(PIP) 'torch>=2.4'
	$(BIN)/python -m pytest tests/python/test_torch.py

lint: $(BIN)/python ## Formatting and lints of both languages
	$(SAY) 'Format and lints of the crate (minutes to compile the first time)'
	cargo fmt --check
	cargo clippy --locked --all-targets --features serde -- -D warnings
	cargo clippy --locked --lib --features python -- -D warnings
	$(SAY) 'Lints and format of Python (seconds)'
	$(PIP) --quiet 'ruff>=0.9,<1'
	$(BIN)/ruff check python tests benchmarks examples tools website
	$(BIN)/ruff format --check python tests benchmarks examples tools website

licences: ## Licences and sources of all crates against deny.toml
	$(PYTHON) tools/licences.py

fuzz: $(INSTALLED) ## Random calls of every Python entry point for ten minutes; ARGS="--minutes 1 --seed 7"
	$(BIN)/python -m tests.fuzz $(ARGS)

leak: $(INSTALLED) ## Memory during 10^6 solves of each kind; ARGS="--solves 100000"
	$(BIN)/python -m benchmarks.leak $(ARGS)

interrupts: $(INSTALLED) ## Seconds from Ctrl-C to the exception, call by call; ARGS="--busy 4" beside busy processes
	$(BIN)/python -m benchmarks.interrupts $(ARGS)

bench: ## Criterion benchmarks, quick profile
	$(SAY) 'Benches of the crate, quick profile (minutes to compile the first time)'
	cargo bench --locked -- --quick

benchmark: $(INSTALLED) ## Beside SciPy, heyoka, geomstats, InterpolatePy and others, into docs/benchmarks.md; ARGS="--only cubic"
	$(SAY) 'Comparison with other libraries (9 minutes; they are installed the first time)'
	$(BIN)/python -m benchmarks.compare $(ARGS)

gallery: $(INSTALLED) ## The examples, with their figures and numbers, into docs/gallery.md and docs/figures; the picture of the README
	$(SAY) 'Examples of the gallery, and the picture of the README (1 to 3 minutes; a line for each)'
	OPENBLAS_NUM_THREADS=1 OMP_NUM_THREADS=1 $(BIN)/python examples/gallery.py
	$(BIN)/python examples/moving_picture.py

boundary: $(INSTALLED) ## 16000 random boundary problems of Riemannian cubics, into docs/boundary_problems.md
	$(SAY) 'Random boundary problems (2 to 4 minutes)'
	RAYON_NUM_THREADS=1 $(BIN)/python -m benchmarks.boundary.solved $(ARGS)

boundary-cost: $(INSTALLED) ## What solutions of 2000 boundary problems cost beside others, into docs/boundary_cost.md
	$(SAY) 'Cost of solutions (with a progress bar)'
	RAYON_NUM_THREADS=1 $(BIN)/python -m benchmarks.boundary.cost $(ARGS)

control-points: $(INSTALLED) ## Other control points on 1000 random boundary problems, into docs/control_points.md
	$(SAY) 'Control points (9 minutes)'
	RAYON_NUM_THREADS=1 $(BIN)/python -m benchmarks.boundary.control_points $(ARGS)

accuracy: $(INSTALLED) ## Errors against 50 digits, into docs/accuracy.md; ARGS="--only subspaces"
	$(SAY) 'Errors against 50 digits (with a progress bar)'
	$(BIN)/python -m benchmarks.accuracy $(ARGS)

study: $(INSTALLED) ## Integrators of cubics compared, into docs/integrators.md and docs/figures
	$(SAY) 'Integrators compared (with a progress bar); without heyoka if it cannot be installed'
	-$(PIP) --quiet 'heyoka>=7,<8'
	RAYON_NUM_THREADS=1 OPENBLAS_NUM_THREADS=1 $(BIN)/python -m benchmarks.study

paper-map: $(BIN)/python ## Every item of the paper with its function, test and report, into docs/paper.md
	$(BIN)/python -m tools.paper_map

stub: $(INSTALLED) ## The docstrings of the compiled module, into python/stiefel_rs/_core.pyi for editors
	$(PIP) --quiet 'ruff>=0.9,<1'
	$(BIN)/python -m tools.stub_docstrings
	$(BIN)/ruff format python/stiefel_rs/_core.pyi

doc: ## Rust documentation, with rendered mathematics
	$(SAY) 'Rust documentation into target/doc (minutes the first time)'
	cargo doc --locked --no-deps

# By its name the package that is there gets its extra; by its folder it would be built once more.
$(DOCS_INSTALLED): $(INSTALLED)
	$(SAY) 'Install MkDocs and its plugins'
	$(PIP) 'stiefel-rs[docs]'
	@touch $@

docs: $(DOCS_INSTALLED) ## The documentation site, into site/
	$(SAY) 'Documentation site into site/ (15 seconds)'
	NO_MKDOCS_2_WARNING=1 $(BIN)/python -m mkdocs build --strict

check-docs: docs ## The pages of site/ in Chromium: search, tables, signatures, small screens
	$(SAY) 'Pages in Chromium, wide and narrow (2 minutes)'
	$(BIN)/python -m pytest tests/site

wheels: $(BIN)/python ## Source distribution, and a wheel that is built from it, into dist/; both checked
	$(SAY) 'Source distribution and wheel into dist/ (10 minutes)'
	$(PIP) --quiet 'maturin>=1.9.4,<2' 'twine>=6.1'
	rm -rf dist
	$(BIN)/maturin build --release --locked --sdist --out dist
	$(BIN)/twine check --strict dist/*
	$(BIN)/python tools/contents.py dist/*

clean: ## Remove everything that make has made
	rm -rf $(VENV) .venv-bench $(OUT) dist site target
