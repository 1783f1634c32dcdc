# Every target makes what it needs: a .venv of its own, the built extension, the tools.
# The Rust target directory and .venv stay inside this clone.

# The first Python of at least 3.11; override with make PYTHON=/path/to/python.
NEW_ENOUGH := import sys; sys.exit(sys.version_info < (3, 11))
PYTHON ?= $(shell for p in python3 python3.11 python3.12 python3.13 python3.14 python; do \
	"$$p" -c '$(NEW_ENOUGH)' 2>/dev/null && echo "$$p" && break; done)
VENV   := .venv
BIN    := $(VENV)/bin
STAMP  := $(VENV)/.installed
DOCS_STAMP := $(VENV)/.docs_tools
RUST   := $(shell find rust -name '*.rs' -o -name Cargo.toml) Cargo.toml Cargo.lock

SOURCES := python tests reference examples benchmarks docs .ci

.DEFAULT_GOAL := all
.PHONY: all help demo test tools test-rust test-python oldest coverage campaign lint format build docs wheel sdist bench clean

all: format lint build test  ## format, lint, build and test

help:  ## list the targets
	@grep -E '^[a-z-]+:.*##' $(MAKEFILE_LIST) | sed -E 's/:[^#]*## /\t/' | expand -t 14

demo: build  ## build, then run the eight-mass chain from record to damage
	$(BIN)/antires demo --out demo_output

# Rust's tests and .venv at one time: linking keeps one core busy, and pip waits for the network.
test:  ## cargo and pytest suites
	+$(MAKE) --no-print-directory --jobs 2 test-rust tools
	+$(MAKE) --no-print-directory test-python

test-rust:  ## tests of the Rust core
	cargo test --locked

# One worker a core, each with one thread of BLAS.
PYTEST = OPENBLAS_NUM_THREADS=1 $(BIN)/python -m pytest --numprocesses auto --dist worksteal

tools: $(STAMP) $(DOCS_STAMP)

test-python: tools  ## tests of the Python package
	$(PYTEST)

# Packages of the oldest versions that pyproject.toml promises, beside the newest tools that run tests. PyNiteFEA
# wants a newer NumPy; its tests skip. Old packages warn of what newer ones beside them deprecate.
OLDEST := $(VENV)_oldest
PINS := import re, tomllib; own = tomllib.load(open("pyproject.toml", "rb"))["project"]; \
	every = sum(own["optional-dependencies"].values(), own["dependencies"]); \
	print(*(re.sub(r"\[.*?\]", "", one).replace(">=", "==") for one in every if ">=" in one), sep="\n")

oldest:  ## tests of the Python package with the oldest packages that it promises
	@test -x $(OLDEST)/bin/python || $(PYTHON) -m venv $(OLDEST)
	$(PYTHON) -c '$(PINS)' > $(OLDEST)/pins.txt
	$(OLDEST)/bin/python -m pip install --quiet --disable-pip-version-check --constraint $(OLDEST)/pins.txt \
		--editable ".[all]" $(filter-out "PyNiteFEA%,$(TEST_TOOLS))
	OPENBLAS_NUM_THREADS=1 $(OLDEST)/bin/python -m pytest --numprocesses auto --dist worksteal \
		-W ignore::DeprecationWarning tests

# Not in every run: before Python 3.12 a tracer costs a quarter of the time of a test, and no limit hangs on the figure.
coverage: tools  ## the same with the coverage of the package, line by line into target/coverage/html
	$(PYTEST) --cov antires_rs --cov-report html

campaign: $(STAMP)  ## the studies of which the suites have a part, thirty times the random files and cases, and fuzzing
	PROPTEST_CASES=4000 cargo test --locked
	$(PYTEST) -m campaign
	ANTIRES_EXAMPLES=30 $(PYTEST) $(wildcard tests/*/test_any_*.py)
	$(PYTEST) $(wildcard benchmarks/test_*.py)
	OPENBLAS_NUM_THREADS=1 $(BIN)/python -m benchmarks.search_study --least 95
	$(BIN)/python -m pip install --quiet --disable-pip-version-check $(call group,fuzz)
	OPENBLAS_NUM_THREADS=1 $(BIN)/python -m benchmarks.fuzz_files --seconds 600

lint: build  ## clippy, rustdoc, ruff, import contracts, mypy, stubtest
	cargo fmt --check
	cargo clippy --locked --workspace --all-targets --all-features -- -D warnings
	RUSTDOCFLAGS="-D warnings" cargo doc --locked --no-deps -p antires-core
	@if cargo deny --version >/dev/null 2>&1; then cargo deny check; \
		else echo "cargo-deny is not installed: advisories, licences and sources of crates are not checked"; fi
	$(BIN)/ruff format --check $(SOURCES)
	$(BIN)/ruff check $(SOURCES)
	$(BIN)/lint-imports
	$(BIN)/mypy
	$(BIN)/python -m mypy.stubtest antires_rs --mypy-config-file pyproject.toml --allowlist .ci/stubtest_allowlist.txt

format: $(STAMP)  ## format the sources
	cargo fmt
	$(BIN)/ruff format $(SOURCES)

build: $(STAMP)  ## make .venv and build the extension into it

$(STAMP): pyproject.toml $(RUST)
	@echo "Making $(VENV) and building the Rust core into it: a few minutes the first time, seconds afterwards."
	$(VENV_MADE)
	@$(BIN)/python -m pip install --quiet --disable-pip-version-check $(BUILD_TOOLS) $(TEST_TOOLS)
	@PATH="$(CURDIR)/$(BIN):$$PATH" $(BIN)/python -m pip install --quiet --disable-pip-version-check \
		--no-build-isolation --editable ".[all]"
	@touch $@

$(DOCS_STAMP): pyproject.toml | $(STAMP)
	@$(BIN)/python -m pip install --quiet --disable-pip-version-check $(DOCS_TOOLS)
	@touch $@

define VENV_MADE
@test -n "$(PYTHON)" || { echo "No Python of at least 3.11 found: make PYTHON=/path/to/python" >&2; exit 1; }
@$(BIN)/python -m pip --version >/dev/null 2>&1 || $(PYTHON) -m venv $(VENV)
endef

# What pyproject.toml lists, quoted for the shell (older pip cannot read dependency groups).
listed = $(shell $(PYTHON) -c 'import tomllib; print(*(chr(34) + t + chr(34) for t in tomllib.load(open("pyproject.toml", "rb"))$(1)))')
group = $(call listed,["dependency-groups"]["$(1)"])
TEST_TOOLS = $(call group,test)
DOCS_TOOLS = $(call group,docs)
BUILD_TOOLS = $(call listed,["build-system"]["requires"])

docs: tools  ## pages and executed gallery into docs/_build/html, warnings are errors
	$(BIN)/python -m sphinx -W --keep-going -b html docs docs/_build/html

# Messages of dependencies name their source files; the folders of this machine stay out of a wheel.
AWAY = build.rustflags=["--remap-path-prefix=$(or $(CARGO_HOME),$(HOME)/.cargo)=cargo","--remap-path-prefix=$(CURDIR)=."]

wheel: $(BIN)/maturin  ## build a wheel, with its bill of materials inside, into dist/
	$(BIN)/maturin build --release --locked --config '$(AWAY)' --out dist
	$(BIN)/python .ci/tidy_wheel.py --strict dist/*.whl

sdist: $(BIN)/maturin  ## build a source distribution into dist/
	$(BIN)/maturin sdist --out dist

$(BIN)/maturin: pyproject.toml
	$(VENV_MADE)
	@$(BIN)/python -m pip install --quiet --disable-pip-version-check $(BUILD_TOOLS)
	@touch $@

bench: build  ## speed and accuracy tables of the README
	$(BIN)/python -m benchmarks.objective_speed
	$(BIN)/python -m benchmarks.chain8_study

clean:  ## remove everything that was built
	rm -rf $(VENV) $(OLDEST) target dist demo_output python/antires_rs/*.so
	rm -rf docs/_build docs/gallery docs/api/generated docs/api/backreferences docs/sg_execution_times.rst
