# make setup | setup-dev | run | test | test-long | lint | docs | peers | soil | parquet | crate | bench | verify | scale | shaking-table | faults | fuzz | lock | clean
PYTHON ?= python3
VENV := .venv
BIN := $(VENV)/bin
CORES ?= 2
export PATH := $(CURDIR)/$(BIN):$(PATH)

.PHONY: setup setup-dev run test tests test-long lint docs format peers soil parquet crate bench verify scale shaking-table faults fuzz lock clean help
.DEFAULT_GOAL := help

help: ## list the targets
	@grep -hE '^[a-z-]+:.*## ' $(MAKEFILE_LIST) | sed 's/:.*## /\t/' | expand -t 16

PIP_INSTALL := $(BIN)/python -m pip install --quiet --disable-pip-version-check --no-compile
# pip compiles bytecode on one core, that of the packages' own tests, too, which take a third. Files that are no Python
# (templates of packages) are skipped.
COMPILE := $(BIN)/python -m compileall -qq -j 0 -x '/tests?/' $(VENV)/lib src || true

# The stamps depend on the locks: the environment is rebuilt only if a lock has changed.
$(VENV)/.stamp: requirements.lock pyproject.toml
	@command -v $(PYTHON) >/dev/null || { echo "no program $(PYTHON) here; try: make PYTHON=python3 $(MAKECMDGOALS)" >&2; exit 1; }
	@$(PYTHON) -c 'import sys; sys.exit(sys.version_info < (3, 11))' || { echo "overturning needs Python 3.11 or newer; try: make PYTHON=python3.12 $(MAKECMDGOALS)" >&2; exit 1; }
	$(PYTHON) -m venv $(VENV)
	$(PIP_INSTALL) --require-hashes --requirement requirements.lock
	$(PIP_INSTALL) --no-deps --no-build-isolation --editable .
	$(COMPILE)
	@touch $@

# A package that is in both locks (with a marker) has the same versions in both, so tests use the versions of a run.
$(VENV)/.stamp-dev: $(VENV)/.stamp requirements-dev.lock
	$(PIP_INSTALL) --require-hashes --requirement requirements-dev.lock
	$(COMPILE)
	@touch $@

setup: $(VENV)/.stamp ## make .venv for runs from the hashed lock requirements.lock

setup-dev: $(VENV)/.stamp-dev ## install what tests, lint and docs need on top (requirements-dev.lock)

run: setup ## run the default study, or another: make run STUDY=config/mine.yaml; resumes an interrupted run; VERBOSE=1: messages of Snakemake
	@$(BIN)/snakemake --cores $(CORES) $(if $(STUDY),--configfile "$(STUDY)") $(if $(filter-out 0,$(VERBOSE)),--verbose)

# Two processes already use two cores: further threads of linear algebra would only wait for one. Compiled tests are
# kept, as pytest takes seconds to compile their assertions.
PYTEST := env -u PYTHONDONTWRITEBYTECODE OPENBLAS_NUM_THREADS=1 $(BIN)/python -m pytest --numprocesses 2 --dist loadfile --no-loadscope-reorder

test: setup-dev ## lint and tests in parallel: about four minutes on two cores, including the compilation of kernels
	@$(MAKE) --no-print-directory --jobs=2 lint tests

tests: setup-dev
	$(PYTEST) -m "not long"

test-long: setup-dev ## the long tests: many cases, other processors, a cluster, corrupted input; another four minutes
	$(PYTEST) -m long

lint: setup-dev ## ruff, mypy, snakefmt, snakemake --lint
	$(BIN)/ruff check .
	$(BIN)/ruff format --check .
	$(BIN)/mypy
	$(BIN)/snakefmt --check Snakefile workflow verification
	$(BIN)/snakemake --lint
	$(BIN)/snakemake --lint --workflow-profile none --snakefile verification/Snakefile

docs: setup-dev ## build the documentation into site/ and check its links, without network
	NO_MKDOCS_2_WARNING=1 $(BIN)/mkdocs build --strict --quiet

peers: setup-dev ## install the other physics engines (group `peers`), for bench, verify and one test
	$(PIP_INSTALL) "box2d>=2.3" "mujoco>=3.2" "pybullet>=3.2" "pymunk>=6.9"
	@# Only the compiled solver of compas-lmgc90 is used; its dependencies, a viewer among them, take 700 MB.
	$(PIP_INSTALL) --no-deps "compas-lmgc90>=0.1.11" || echo "without LMGC90"

soil: setup ## install the packages for site response (group `soil`)
	$(PIP_INSTALL) "pandas>=2.2" "pystrata>=0.5.4"

parquet: setup ## install the package for Parquet files (group `parquet`)
	$(PIP_INSTALL) "pyarrow>=15"

crate: setup-dev ## install the validator of research crates (group `crate`), for one test
	$(PIP_INSTALL) "roc-validator>=0.7"

bench: peers ## compare the speed of the kernel with scalar code, other engines, and another checkout: OTHER=folder
	$(if $(OTHER),$(BIN)/python -m verification.paired $(OTHER))
	$(BIN)/snakemake --workflow-profile none --snakefile verification/Snakefile --cores $(CORES) bench

verify: setup-dev ## compute error against run time and the stability map; write the figures into the docs
	@$(PIP_INSTALL) "box2d>=2.3" "mujoco>=3.2" "pybullet>=3.2" "pymunk>=6.9" || echo "without other engines"
	OVERTURNING_EVERY_TARGET=1 $(PYTEST) -q -m long
	$(BIN)/snakemake --workflow-profile none --snakefile verification/Snakefile --cores $(CORES)

scale: setup-dev ## test the largest study sizes and reproducibility; half an hour, 10 GB of disk
	$(BIN)/python -m verification.scale

shaking-table: setup-dev ## compare predictions with shaking-table tests: DATA=folder (sources: docs/shaking-table.md)
	$(BIN)/python -m verification.shaking_table $(or $(DATA),resources/shaking-table) --threads $(CORES)
	$(BIN)/python -m verification.shaking_table.scan_page $(or $(DATA),resources/shaking-table) --threads $(CORES)

faults: setup-dev ## interrupt and damage a small study fifty times, and resume it each time
	$(BIN)/python -m verification.faults

SECONDS ?= 600
fuzz: setup-dev ## test with corrupted input for ten minutes, or SECONDS=
	FUZZ_SECONDS=$(SECONDS) $(BIN)/python -m pytest -p no:xdist tests/fuzz

format: setup-dev
	$(BIN)/ruff check --fix .
	$(BIN)/ruff format .
	$(BIN)/snakefmt Snakefile workflow verification

LOCK := $(BIN)/uv pip compile --quiet --universal --python-version 3.11 --generate-hashes --no-annotate --no-header
# The second lock lists no package that the first installs on every platform.
lock: setup ## update the hashed locks
	$(PIP_INSTALL) uv
	$(LOCK) --extra build --extra cluster pyproject.toml --output-file requirements.lock
	$(LOCK) --extra build --extra cluster --extra test --extra docs --constraint requirements.lock \
	  $$(sed -nE 's/^([a-z0-9._-]+)==[^;]*$$/--no-emit-package \1/p' requirements.lock) \
	  pyproject.toml --output-file requirements-dev.lock

clean: ## remove results and the environment
	rm -rf results site .snakemake $(VENV)
