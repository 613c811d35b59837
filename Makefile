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

# The stamp carries the lock: a changed lock sets the environment up again, an unchanged one costs nothing.
$(VENV)/.stamp: requirements.lock pyproject.toml
	@command -v $(PYTHON) >/dev/null || { echo "no program $(PYTHON) here; try: make PYTHON=python3 $(MAKECMDGOALS)" >&2; exit 1; }
	@$(PYTHON) -c 'import sys; sys.exit(sys.version_info < (3, 11))' || { echo "overturning needs Python 3.11 or newer; try: make PYTHON=python3.12 $(MAKECMDGOALS)" >&2; exit 1; }
	$(PYTHON) -m venv $(VENV)
	$(BIN)/python -m pip install --quiet --disable-pip-version-check --require-hashes --requirement requirements.lock
	$(BIN)/python -m pip install --quiet --disable-pip-version-check --no-deps --no-build-isolation --editable .
	@touch $@

setup: $(VENV)/.stamp ## make .venv from the hashed lock

run: setup ## run the default study, or another: make run STUDY=config/mine.yaml; goes on after a killed run; VERBOSE=1: Snakemake speaks for itself
	@$(BIN)/snakemake --cores $(CORES) $(if $(STUDY),--configfile $(STUDY)) $(if $(filter-out 0,$(VERBOSE)),--verbose)

PYTEST := $(BIN)/python -m pytest --numprocesses 2 --dist loadfile --no-loadscope-reorder

test: setup ## lint and tests, side by side: four minutes on two cores, kernels compiled within
	@$(MAKE) --no-print-directory --jobs=2 lint tests

tests: setup
	$(PYTEST) -m "not long"

test-long: setup ## the other tests: proofs by many cases, other processors, a cluster, spoilt input; as long again
	$(PYTEST) -m long

lint: setup ## ruff, mypy, snakefmt, snakemake --lint
	$(BIN)/ruff check .
	$(BIN)/ruff format --check .
	$(BIN)/mypy
	$(BIN)/snakefmt --check Snakefile workflow verification
	$(BIN)/snakemake --lint
	$(BIN)/snakemake --lint --workflow-profile none --snakefile verification/Snakefile

docs: setup ## build the documentation site into site/, links checked, without network
	NO_MKDOCS_2_WARNING=1 $(BIN)/mkdocs build --strict --quiet

peers: setup ## install the other engines (group `peers`): for bench, verify and one live test
	$(BIN)/python -m pip install --quiet --disable-pip-version-check "box2d>=2.3" "mujoco>=3.2" "pybullet>=3.2" "pymunk>=6.9"

soil: setup ## install what motion through soil needs (group `soil`)
	$(BIN)/python -m pip install --quiet --disable-pip-version-check "pandas>=2.2" "pystrata>=0.5.4"

parquet: setup ## install what cubes as Parquet files need (group `parquet`)
	$(BIN)/python -m pip install --quiet --disable-pip-version-check "pyarrow>=15"

crate: setup ## install what checks a research crate against its profile (group `crate`), for one test
	$(BIN)/python -m pip install --quiet --disable-pip-version-check "roc-validator>=0.7"

bench: peers ## how fast the kernel is, against scalar code and other engines; and than another checkout: OTHER=folder
	$(if $(OTHER),$(BIN)/python -m verification.paired $(OTHER))
	$(BIN)/snakemake --workflow-profile none --snakefile verification/Snakefile --cores $(CORES) bench

verify: setup ## error against run time, map of stability; puts the figures into the docs
	@$(BIN)/python -m pip install --quiet --disable-pip-version-check "box2d>=2.3" "mujoco>=3.2" "pybullet>=3.2" "pymunk>=6.9" || echo "without other engines"
	OVERTURNING_EVERY_TARGET=1 $(PYTEST) -q -m long
	$(BIN)/snakemake --workflow-profile none --snakefile verification/Snakefile --cores $(CORES)

scale: setup ## how large a study may be, and the same bytes everywhere; half an hour, 10 GB of disk
	$(BIN)/python -m verification.scale

shaking-table: setup ## predictions beside shaking-table tests: DATA=folder (docs/shaking-table.md says where they are)
	$(BIN)/python -m verification.shaking_table $(or $(DATA),resources/shaking-table) --threads $(CORES)

faults: setup ## fifty kills and injuries to a small study, each followed by the one command that goes on
	$(BIN)/python -m verification.faults

SECONDS ?= 600
fuzz: setup ## spoilt input of every kind for ten minutes, or SECONDS=
	FUZZ_SECONDS=$(SECONDS) $(BIN)/python -m pytest -p no:xdist tests/fuzz

format: setup
	$(BIN)/ruff check --fix .
	$(BIN)/ruff format .
	$(BIN)/snakefmt Snakefile workflow verification

lock: setup ## resolve the hashed lock again
	$(BIN)/python -m pip install --quiet --disable-pip-version-check uv
	$(BIN)/uv pip compile --quiet --universal --python-version 3.11 --generate-hashes --no-annotate --no-header \
	  --extra test --extra build --extra docs --extra cluster pyproject.toml --output-file requirements.lock

clean: ## remove results and the environment
	rm -rf results site .snakemake $(VENV)
