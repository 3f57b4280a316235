# make suite: learn tests from the BDI models and run each against the simulated world, on two workers.
# make test:  the project's own tests (4 minutes), without the long ones; those are make slow (8 minutes).
# OPTIONS=... is handed on to pytest by these.
# make experiment: docs/experiment.md and docs/agreement.md, beside the paper's figures (5 minutes; agreement alone: 2).
# make adequacy: docs/adequacy.md, seeded faults with each suite (hours; ended at any time, it goes on where it was).
# make false-alarms: docs/false-alarms.md, what fails on the unchanged controller (40 sessions; resumable as well).
# make engines: docs/engines.md, how far the two physics engines agree (10 minutes; resumable as well).
# make closure: docs/closure.md, how fast suites and the closing loop reach points (ten seeds: hours; resumable as well).
# make campaign: docs/campaign.md, 6,560 runs (45 minutes; ended at any time, it goes on where it was).
# Each creates the environment in $(VENV) first, from nothing but Python 3.11, make and a compiler.

PYTHON ?= $(shell command -v python3.11 || command -v python3)
VENV ?= .venv
BIN = $(VENV)/bin
# A test that hangs ends after so many seconds, with its worker: where it was is shown.
PATIENCE = -o faulthandler_exit_on_timeout=true -o faulthandler_timeout
# Hundreds of processes are started by the tests, and two workers by each suite: none should compile all modules anew.
unexport PYTHONDONTWRITEBYTECODE

.PHONY: suite test slow lint bench experiment agreement adequacy false-alarms engines closure campaign pictures clean

suite: $(VENV)/.installed
	$(BIN)/pytest --hri-suite=rl -n 2

test: $(VENV)/.installed
	$(BIN)/pytest -n 2 --dist worksteal $(PATIENCE)=300 $(OPTIONS)

slow: $(VENV)/.installed
	$(BIN)/pytest -n 2 --dist worksteal -m "slow or hypothesis" --hypothesis-profile=thorough $(PATIENCE)=1200 $(OPTIONS)

lint: $(VENV)/.installed
	$(BIN)/ruff check .
	$(BIN)/ruff format --check .
	$(BIN)/mypy
	$(BIN)/lint-imports
	$(BIN)/python -m pytest_hricdv.bdi lint models_bdi/table_assembly.mas2j

bench: $(VENV)/.installed
	$(BIN)/python -m benchmarks.end_to_end
	$(BIN)/python -m benchmarks.world

experiment: $(VENV)/.installed
	$(BIN)/python -m studies.experiment
	$(BIN)/python -m studies.agreement

agreement: $(VENV)/.installed
	$(BIN)/python -m studies.agreement

adequacy: $(VENV)/.installed
	$(BIN)/python -m studies.adequacy

false-alarms: $(VENV)/.installed
	$(BIN)/python -m studies.false_alarms --write

engines: $(VENV)/.installed
	$(BIN)/python -m studies.engines

closure: $(VENV)/.installed
	$(BIN)/python -m studies.closure

campaign: $(VENV)/.installed
	$(BIN)/python -m benchmarks.campaign --write

pictures: $(VENV)/.installed
	$(BIN)/python -m studies.screenshots

$(VENV)/.installed: pyproject.toml
	$(PYTHON) -m venv $(VENV)
	$(BIN)/python -m pip install --quiet --upgrade "pip>=25.1"
	$(BIN)/python -m pip install --quiet --editable ".[sim]" --group dev
	touch $@

clean:
	rm -rf $(VENV) .pytest_cache .mypy_cache .ruff_cache .hypothesis hri-report hri-experiment hri-agreement hri-adequacy hri-false-alarms hri-engines hri-closure
