# make setup | run | test | test-long | lint | docs | peers | soil | parquet | crate | bench | verify | scale | shaking-table | faults | fuzz | lock | clean
PYTHON ?= python3
VENV := .venv
BIN := $(VENV)/bin
CORES ?= 2
export PATH := $(CURDIR)/$(BIN):$(PATH)

.PHONY: setup run test tests test-long lint docs format peers soil parquet crate bench verify scale shaking-table faults fuzz lock clean help
.DEFAULT_GOAL := help

help: ## list the targets
	@grep -hE '^[a-z-]+:.*## ' $(MAKEFILE_LIST) | sed 's/:.*## /\t/' | expand -t 16

# The stamp depends on the lock: the environment is rebuilt only if the lock has changed.
$(VENV)/.stamp: requirements.lock pyproject.toml
	@command -v $(PYTHON) >/dev/null || { echo "no program $(PYTHON) here; try: make PYTHON=python3 $(MAKECMDGOALS)" >&2; exit 1; }
	@$(PYTHON) -c 'import sys; sys.exit(sys.version_info < (3, 11))' || { echo "overturning needs Python 3.11 or newer; try: make PYTHON=python3.12 $(MAKECMDGOALS)" >&2; exit 1; }
	$(PYTHON) -m venv $(VENV)
	$(BIN)/python -m pip install --quiet --disable-pip-version-check --require-hashes --requirement requirements.lock
	$(BIN)/python -m pip install --quiet --disable-pip-version-check --no-deps --no-build-isolation --editable .
	@touch $@

setup: $(VENV)/.stamp ## make .venv from the hashed lock

run: setup ## run the default study, or another: make run STUDY=config/mine.yaml; resumes an interrupted run; VERBOSE=1: messages of Snakemake
	@$(BIN)/snakemake --cores $(CORES) $(if $(STUDY),--configfile $(STUDY)) $(if $(filter-out 0,$(VERBOSE)),--verbose)

PYTEST := $(BIN)/python -m pytest --numprocesses 2 --dist loadfile --no-loadscope-reorder

test: setup ## lint and tests in parallel: four minutes on two cores, including the compilation of kernels
	@$(MAKE) --no-print-directory --jobs=2 lint tests

tests: setup
	$(PYTEST) -m "not long"

test-long: setup ## the long tests: many cases, other processors, a cluster, corrupted input; another four minutes
	$(PYTEST) -m long

lint: setup ## ruff, mypy, snakefmt, snakemake --lint
	$(BIN)/ruff check .
	$(BIN)/ruff format --check .
	$(BIN)/mypy
	$(BIN)/snakefmt --check Snakefile workflow verification
	$(BIN)/snakemake --lint
	$(BIN)/snakemake --lint --workflow-profile none --snakefile verification/Snakefile

docs: setup ## build the documentation into site/ and check its links, without network
	NO_MKDOCS_2_WARNING=1 $(BIN)/mkdocs build --strict --quiet

peers: setup ## install the other physics engines (group `peers`), for bench, verify and one test
	$(BIN)/python -m pip install --quiet --disable-pip-version-check "box2d>=2.3" "mujoco>=3.2" "pybullet>=3.2" "pymunk>=6.9"
	@# Only the compiled solver of compas-lmgc90 is used; its dependencies, a viewer among them, take 700 MB.
	$(BIN)/python -m pip install --quiet --disable-pip-version-check --no-deps "compas-lmgc90>=0.1.11" || echo "without LMGC90"

soil: setup ## install the packages for site response (group `soil`)
	$(BIN)/python -m pip install --quiet --disable-pip-version-check "pandas>=2.2" "pystrata>=0.5.4"

parquet: setup ## install the package for Parquet files (group `parquet`)
	$(BIN)/python -m pip install --quiet --disable-pip-version-check "pyarrow>=15"

crate: setup ## install the validator of research crates (group `crate`), for one test
	$(BIN)/python -m pip install --quiet --disable-pip-version-check "roc-validator>=0.7"

bench: peers ## compare the speed of the kernel with scalar code, other engines, and another checkout: OTHER=folder
	$(if $(OTHER),$(BIN)/python -m verification.paired $(OTHER))
	$(BIN)/snakemake --workflow-profile none --snakefile verification/Snakefile --cores $(CORES) bench

verify: setup ## compute error against run time and the stability map; write the figures into the docs
	@$(BIN)/python -m pip install --quiet --disable-pip-version-check "box2d>=2.3" "mujoco>=3.2" "pybullet>=3.2" "pymunk>=6.9" || echo "without other engines"
	OVERTURNING_EVERY_TARGET=1 $(PYTEST) -q -m long
	$(BIN)/snakemake --workflow-profile none --snakefile verification/Snakefile --cores $(CORES)

scale: setup ## test the largest study sizes and reproducibility; half an hour, 10 GB of disk
	$(BIN)/python -m verification.scale

shaking-table: setup ## compare predictions with shaking-table tests: DATA=folder (sources: docs/shaking-table.md)
	$(BIN)/python -m verification.shaking_table $(or $(DATA),resources/shaking-table) --threads $(CORES)

faults: setup ## interrupt and damage a small study fifty times, and resume it each time
	$(BIN)/python -m verification.faults

SECONDS ?= 600
fuzz: setup ## test with corrupted input for ten minutes, or SECONDS=
	FUZZ_SECONDS=$(SECONDS) $(BIN)/python -m pytest -p no:xdist tests/fuzz

format: setup
	$(BIN)/ruff check --fix .
	$(BIN)/ruff format .
	$(BIN)/snakefmt Snakefile workflow verification

lock: setup ## update the hashed lock
	$(BIN)/python -m pip install --quiet --disable-pip-version-check uv
	$(BIN)/uv pip compile --quiet --universal --python-version 3.11 --generate-hashes --no-annotate --no-header \
	  --extra test --extra build --extra docs --extra cluster pyproject.toml --output-file requirements.lock

clean: ## remove results and the environment
	rm -rf results site .snakemake $(VENV)
