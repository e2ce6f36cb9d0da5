# Everything from a clean clone: `make demo` shows the element at work, `make test` tests it.
# Needs Rust, Python 3.11 or later, gcc and make; the rest is set up under .venv and target.

SHELL := /bin/bash
PYTHON ?= python3
CARGO ?= cargo
VENV := .venv
GEARMESH := target/release/gearmesh
DRIVELINES := housing holes planetary response cosimulation rattle sweep loss tutorial
export PYTHON

.PHONY: all setup build demo test lint licenses report examples bench callgrind release clean distclean
.DELETE_ON_ERROR:

all: build

# Python packages under .venv.
setup: $(VENV)/.complete

# What says which packages there are.
PACKAGES := pyproject.toml constraints.txt scripts/packages.py scripts/setup.sh

$(VENV)/.complete: $(PACKAGES)
	scripts/setup.sh

# libclang, for the standard's header in tests.
$(VENV)/.bindgen: $(PACKAGES) | $(VENV)/.complete
	scripts/setup.sh --bindgen

# Those that only tests use.
$(VENV)/.tests-complete: $(VENV)/.complete $(VENV)/.bindgen
	scripts/setup.sh test
	touch $@

# fmi-sim, the one simulator among them that comes as Rust; it needs bindgen, too, but cargo looks into no configuration of ours
# to install.
$(VENV)/bin/fmi-sim: | $(VENV)/.bindgen
	LIBCLANG_PATH=$(CURDIR)/$(VENV)/libclang C_INCLUDE_PATH=$(CURDIR)/$(VENV)/c-include \
	$(CARGO) install --quiet --locked --debug --root $(VENV) fmi-sim@0.7.0

# Other simulators, for examples/drivelines and examples/hosts.
$(VENV)/.examples-packages: $(VENV)/.tests-complete
	scripts/setup.sh test examples
	$(VENV)/bin/python scripts/without_display.py
	touch $@

$(VENV)/.examples-complete: $(VENV)/.examples-packages $(VENV)/bin/fmi-sim
	touch $@

# The command target/release/gearmesh and the FMU's library beside it. Tests give some dependencies features of their own, and cargo keeps one
# library: a build for tests selects what they do, so that they compile nothing again.
SELECTION := --package gearmesh --package gearmesh-command
check test: SELECTION := --workspace --lib --bins --tests
build:
	$(CARGO) build --release $(SELECTION)

# All packages are to be had for the lowest Python that README promises, in its first release.
LOWEST_PYTHON := $(shell sed -n 's/^- Python \([0-9.]*\) or later.*/\1.0/p' README.md)
.PHONY: floor
floor: setup
	$(VENV)/bin/python scripts/packages.py > $(VENV)/all-packages.txt
	$(VENV)/bin/python -m pip install --quiet --disable-pip-version-check --dry-run --no-deps --ignore-installed --only-binary=:all: \
	    --python-version $(LOWEST_PYTHON) --target target/none --requirement $(VENV)/all-packages.txt || \
	    { echo "make: constraints.txt does not resolve for Python $(LOWEST_PYTHON), which README promises" >&2; exit 1; }

# Whatever is to be had from elsewhere, so that what is missing shows before anything is compiled.
.PHONY: packages
packages: floor $(VENV)/.bindgen $(VENV)/.docs-complete $(VENV)/.examples-packages
	$(CARGO) fetch --quiet --locked

# What the lints need beside what a build needs, said before any work.
.PHONY: tools
tools:
	@$(CARGO) fmt --version >/dev/null 2>&1 || { echo "make: rustfmt is missing: rustup component add rustfmt (Debian: apt install rustfmt)" >&2; exit 1; }
	@$(CARGO) clippy --version >/dev/null 2>&1 || { echo "make: clippy is missing: rustup component add clippy (Debian: apt install rust-clippy)" >&2; exit 1; }

# Cheapest first. The lints share their compiled dependencies, and so do build and tests.
lint: tools floor $(VENV)/.bindgen
	$(VENV)/bin/python scripts/imports.py
	$(CARGO) fmt --all --check
	$(CARGO) clippy --release --workspace --all-targets -- -D warnings
	RUSTDOCFLAGS="-D warnings" $(CARGO) doc --release --workspace --no-deps
	$(VENV)/bin/python scripts/licenses.py --check

# The licence texts that every FMU carries, after a change of the dependencies; `make lint` compares them.
licenses: setup
	$(VENV)/bin/python scripts/licenses.py

# The pages of docs/ as a site in target/site, with links and figures checked.
.PHONY: docs
docs: build $(VENV)/.docs-complete
	NO_MKDOCS_2_WARNING=1 $(VENV)/bin/python -m mkdocs build --quiet --strict
	$(VENV)/bin/python -m scripts.docs.check target/site

$(VENV)/.docs-complete: $(VENV)/.complete
	scripts/setup.sh docs
	touch $@

# Before a commit: format, clippy, unit tests, and the Python tests that take no more than a few seconds and no other simulator. Three
# minutes once everything is compiled; `make test` runs the rest.
EXAMPLES_TESTED := tests/python/test_drivelines.py tests/python/test_drivelines_sweep.py tests/python/test_hosts.py
.PHONY: check
check: tools $(VENV)/.tests-complete build
	$(CARGO) fmt --all --check
	$(CARGO) clippy --release --workspace --all-targets -- -D warnings
	$(CARGO) test --release --workspace --exclude gearmesh-validation --lib --bins
	$(VENV)/bin/python -m pytest -q -m "not slow" $(addprefix --ignore ,$(EXAMPLES_TESTED))

# The build comes first: the tests of the command line pack the library that lies beside it. fmi-sim is
# compiled at the same time: a build leaves a core idle now and then.
test: tools packages lint
	$(MAKE) --no-print-directory -j2 SELECTION='$(SELECTION)' build docs $(VENV)/.examples-complete
	$(CARGO) test --release --workspace
	$(VENV)/bin/python -m pytest -q --numprocesses 2 --dist worksteal tests/python

# The paper's simulations: target/demo/palermo2013.fmu, the plots and index.html.
# Python packages come in while cargo compiles.
demo:
	@$(MAKE) --no-print-directory -j2 setup build
	$(VENV)/bin/python -m demo --out target/demo

# What docs/ says of speed, error and stability (docs/data.md), and the contact of every shipped pair in target/report.
report: examples
	$(CARGO) run --release --package gearmesh-validation -- --python $(VENV)/bin/python
	$(VENV)/bin/python -m demo.frames docs/frames.svg
	$(VENV)/bin/python -m demo.frames docs/frames-ring-gear1.svg gear1
	$(VENV)/bin/python -m demo.frames docs/frames-ring-gear2.svg gear2
	$(GEARMESH) pack --tables resources/tables/palermo2013.json --set coupling=held -o target/hosts.fmu
	$(VENV)/bin/python -m examples.hosts target/hosts.fmu --data docs/data/hosts
	$(GEARMESH) pack --pair resources/pairs/palermo2013.json -o target/constant.fmu
	$(VENV)/bin/python -m validation.adaptive target/constant.fmu target/hosts.fmu --data docs/data/hosts
	$(VENV)/bin/python -m validation.steps --data docs/data/hosts
	$(VENV)/bin/python -m demo --out target/demo --docs docs
	mkdir -p target/report
	for pair in resources/pairs/*.json; do \
	    page=target/report/$$(basename $$pair .json); \
	    $(GEARMESH) report $$pair -o $$page.html --figures $$page || exit 1; \
	done
	$(GEARMESH) study examples/drivelines/pairs/spur-50-50.json -q --restart --torques-nm 150 --refinement coarse -o target/study \
	    --best peak_to_peak_ste_loa_um --require "edge_line_load_n_per_mm<=0" \
	    --vary gear1.tip_relief.amount_um,gear2.tip_relief.amount_um=0..40/optimize \
	    --vary gear1.tip_relief.start.diameter_mm,gear2.tip_relief.start.diameter_mm=150..154/optimize
	cp target/study/figures/measure-of-the-points-in-their-order.svg docs/img/study-optimizer.svg
	cp target/study/samples.csv docs/data/study-optimizer.csv
	cp target/drivelines/*.png target/drivelines/tutorial-*.svg docs/drivelines/
	cp $(addprefix target/drivelines/,response.csv sweep-branches.csv loss.csv holes.csv tutorial.csv) docs/data/drivelines/
	$(VENV)/bin/python -m scripts.docs.figures

# The driveline examples; their plots go to target/drivelines, none into docs.
examples: build $(VENV)/.examples-complete
	for example in $(DRIVELINES); do $(VENV)/bin/python -m examples.drivelines.$$example || exit 1; done

bench: setup $(VENV)/.bindgen
	$(CARGO) bench

# Instructions per evaluation against those recorded in benches/instructions.json.
callgrind: setup
	$(CARGO) build --release --package gearmesh-validation --bin instructions
	$(VENV)/bin/python scripts/callgrind.py

# Everything a user downloads, in target/dist: command, library and FMUs for linux64 and win64, wheels. Needs a linker
# and a Rust for Windows beside the rest; it names what is missing.
.PHONY: release-tools
release-tools:
	@$(PYTHON) -m scripts.release.platforms

release: release-tools $(VENV)/.release-complete
	$(VENV)/bin/python -m scripts.release
	$(VENV)/bin/python -m pytest -q tests/release

$(VENV)/.release-complete: $(VENV)/.tests-complete
	scripts/setup.sh release
	touch $@

clean:
	$(CARGO) clean

# Python packages, too.
distclean: clean
	rm -rf $(VENV)
