# `make reproduce` and `make test` need a Rust toolchain, Python >= 3.10 and make; everything else they install
# themselves, into .venv and target.

PYTHON ?= python3
VENV := .venv
BIN := $(VENV)/bin
OUT ?= out
INSTALLED := $(VENV)/.installed
DOCS_INSTALLED := $(VENV)/.docs-installed
SOURCES := Cargo.toml Cargo.lock pyproject.toml README.md $(shell find src python -name '*.rs' -o -name '*.py' -o -name '*.pyi')

.PHONY: help reproduce report test test-rust test-python test-minimal test-torch lint licences fuzz leak interrupts bench benchmark gallery boundary boundary-cost control-points accuracy study paper-map doc docs wheels clean

help: ## Show this list
	@grep -E '^[a-z-]+:.*##' $(MAKEFILE_LIST) | sed -E 's/:[^#]*## /\t/' | sort | expand -t 16

$(BIN)/python:
	@$(PYTHON) -c 'import sys; sys.exit(sys.version_info < (3, 10))' || { \
		echo "Python >= 3.10 is needed; '$(PYTHON)' is $$($(PYTHON) --version). Say make PYTHON=..." >&2; exit 1; }
	$(PYTHON) -m venv $(VENV)

$(INSTALLED): $(BIN)/python $(SOURCES)
	$(BIN)/python -m pip install --quiet --disable-pip-version-check '.[plot,test]'
	@touch $@

reproduce: $(INSTALLED) ## The paper's statements, tables and figures, recomputed, into out/
	$(BIN)/stiefel-rs reproduce --out $(OUT)

report: $(INSTALLED) ## The same and a report of a few pages, out/report.pdf
	$(BIN)/python -m pip install --quiet --disable-pip-version-check 'stiefel-rs[report]'
	$(BIN)/stiefel-rs reproduce --report --out $(OUT)

test: test-rust test-python ## All tests of both languages

test-rust: ## Unit, integration and documentation tests of the crate
	cargo test --locked --features serde

test-python: $(INSTALLED) ## The Python tests, types and stubs
	$(BIN)/python -m pytest
	$(BIN)/python -m mypy
	$(BIN)/python -m mypy.stubtest stiefel_rs._core

MINIMAL_TESTS := $(addprefix tests/python/test_, readme.py curves.py stiefel.py splines.py spline_input.py velocities.py save.py interpolate.py \
	threads.py)

test-minimal: ## Tests for the oldest packages, with those that are installed: pip install -c tests/python/minimal.txt
	$(PYTHON) -m pytest $(MINIMAL_TESTS)

test-torch: $(INSTALLED) ## The tests of stiefel_rs.torch; installs PyTorch, which is gigabytes
	$(BIN)/python -m pip install --quiet --disable-pip-version-check 'torch>=2.4'
	$(BIN)/python -m pytest tests/python/test_torch.py

lint: $(BIN)/python ## Formatting and lints of both languages
	cargo fmt --check
	cargo clippy --locked --all-targets --features serde -- -D warnings
	cargo clippy --locked --lib --features python -- -D warnings
	$(BIN)/python -m pip install --quiet --disable-pip-version-check 'ruff>=0.9,<1'
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
	cargo bench --locked -- --quick

benchmark: $(INSTALLED) ## Beside SciPy, heyoka, geomstats, InterpolatePy and others, into docs/benchmarks.md; ARGS="--only cubic"
	$(BIN)/python -m benchmarks.compare $(ARGS)

gallery: $(INSTALLED) ## The examples, with their figures and numbers, into docs/gallery.md and docs/figures; the picture of the README
	$(BIN)/python examples/gallery.py
	$(BIN)/python examples/moving_picture.py

boundary: $(INSTALLED) ## 12000 random boundary problems of Riemannian cubics, into docs/boundary_problems.md
	RAYON_NUM_THREADS=1 $(BIN)/python -m benchmarks.boundary.solved $(ARGS)

boundary-cost: $(INSTALLED) ## What solutions of 2000 boundary problems cost beside others, into docs/boundary_cost.md
	RAYON_NUM_THREADS=1 $(BIN)/python -m benchmarks.boundary.cost $(ARGS)

control-points: $(INSTALLED) ## Other control points on 1000 random boundary problems, into docs/control_points.md
	RAYON_NUM_THREADS=1 $(BIN)/python -m benchmarks.boundary.control_points $(ARGS)

accuracy: $(INSTALLED) ## Errors against 50 digits, into docs/accuracy.md
	$(BIN)/python -m benchmarks.accuracy

study: $(INSTALLED) ## Integrators of cubics compared, into docs/integrators.md and docs/figures
	-$(BIN)/python -m pip install --quiet --disable-pip-version-check 'heyoka>=7,<8'
	RAYON_NUM_THREADS=1 OPENBLAS_NUM_THREADS=1 $(BIN)/python -m benchmarks.study

paper-map: $(BIN)/python ## Every item of the paper with its function, test and report, into docs/paper.md
	$(BIN)/python -m tools.paper_map

doc: ## Rust documentation, with rendered mathematics
	cargo doc --locked --no-deps

# By its name the package that is there gets its extra; by its folder it would be built once more.
$(DOCS_INSTALLED): $(INSTALLED)
	$(BIN)/python -m pip install --quiet --disable-pip-version-check 'stiefel-rs[docs]'
	@touch $@

docs: $(DOCS_INSTALLED) ## The documentation site, into site/; runs the examples of the gallery unless they are as they were
	NO_MKDOCS_2_WARNING=1 $(BIN)/python -m mkdocs build --strict

wheels: $(BIN)/python ## Source distribution, and a wheel that is built from it, into dist/; both checked
	$(BIN)/python -m pip install --quiet --disable-pip-version-check 'maturin>=1.9.4,<2' 'twine>=6.1'
	rm -rf dist
	$(BIN)/maturin build --release --locked --sdist --out dist
	$(BIN)/twine check --strict dist/*
	$(BIN)/python tools/contents.py dist/*

clean: ## Remove everything that make has made
	rm -rf $(VENV) .venv-bench $(OUT) dist site target
