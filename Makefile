# make suite: learn tests from the BDI models and run each against the simulated world, on two workers.
# make home-care: the same for the second testbench, examples/home_care.
# make test:  the project's own tests (4 minutes), without the long ones; those are make slow (20 minutes).
# OPTIONS=... is handed on to pytest by these.
# make experiment: docs/studies/experiment.md and docs/studies/agreement.md, beside the paper's figures (5 minutes; agreement alone: 2).
# make adequacy: docs/studies/adequacy.md, seeded faults with each suite (hours; ended at any time, it goes on where it was).
# make false-alarms: docs/studies/false-alarms.md, what fails on the unchanged controller (40 sessions; resumable as well).
# make engines: docs/studies/engines.md, how far the two physics engines agree (10 minutes; resumable as well).
# make closure: docs/studies/closure.md, how fast suites and the closing loop reach points (ten seeds: hours; resumable as well).
# make campaign: the 6,560 runs of docs/studies/campaign.md (45 minutes; interrupted at any time, it resumes).
# make docs: the documentation as a site, docs/_build/index.html (a minute). make dist: wheel and sdist, checked, in dist/.
# Each creates the environment in $(VENV) first, from nothing but a Python from 3.11 to 3.14, and make: `suite` and
# `home-care` install the project and its simulated world, the others the development tools and ROS 2 as well. With 3.11 on
# Linux (x86-64) the world has both physics engines, otherwise MuJoCo, and the tests have ROS 2. Without make: noxfile.py.

PYTHON ?= $(shell for each in python3.11 python3.12 python3.13 python3.14 python3; do command -v $$each && break; done)
VENV ?= .venv
BIN = $(VENV)/bin
ROS = $(VENV)/ros2
# A test that hangs ends after so many seconds, with its worker: where it was is shown.
PATIENCE = -o faulthandler_exit_on_timeout=true -o faulthandler_timeout
# Hundreds of processes are started by the tests, and two workers by each suite: none should compile all modules anew.
unexport PYTHONDONTWRITEBYTECODE

.PHONY: suite home-care test slow ros2 lint bench experiment agreement adequacy false-alarms engines closure campaign pictures docs dist clean

suite: $(VENV)/.suite
	$(BIN)/pytest --hri-suite=rl -n 2

home-care: $(VENV)/.suite
	cd examples/home_care && $(abspath $(BIN))/pytest --hri-suite=rl -n 2

test: $(VENV)/.installed
	$(BIN)/pytest -n 2 --dist worksteal $(PATIENCE)=300 $(OPTIONS)

slow: $(VENV)/.installed
	$(BIN)/pytest -n 3 --dist worksteal -m "slow or hypothesis" --hypothesis-profile=thorough $(PATIENCE)=1200 $(OPTIONS)

lint: $(VENV)/.installed
	$(BIN)/ruff check .
	$(BIN)/ruff format --check .
	$(BIN)/mypy
	cd examples/home_care && $(abspath $(BIN))/mypy
	$(BIN)/lint-imports
	$(BIN)/python -m pytest_hricdv.bdi lint models_bdi/table_assembly.mas2j examples/home_care/models_bdi/home_care.mas2j
	$(BIN)/check-jsonschema --builtin-schema vendor.github-workflows .github/workflows/*.yml
	$(BIN)/check-jsonschema --builtin-schema vendor.citation-file-format CITATION.cff
	$(BIN)/python -m studies.freshness
	$(BIN)/python -m studies.size --check

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
	$(BIN)/python -m pytest_hricdv.campaign run --suite=rl --tests=160 --concretizations=41 --state=hri-campaign.db
	$(BIN)/python -m pytest_hricdv.campaign report --state=hri-campaign.db --output=hri-campaign

pictures: $(VENV)/.installed
	$(BIN)/python -m studies.architecture
	$(BIN)/python -m studies.screenshots

docs: $(VENV)/.docs
	$(BIN)/python -m sphinx --builder html --fresh-env --fail-on-warning --quiet docs docs/_build

dist: $(VENV)/.installed
	rm -rf dist
	$(BIN)/python -m build
	$(BIN)/python -m twine check --strict dist/*
	$(BIN)/python -m pyroma --min=10 --skip-tests=AuthorEmail dist/*.tar.gz

# The documentation needs the project and its own tools, nothing else.
$(VENV)/.docs: pyproject.toml
	test -f $(VENV)/.installed || $(PYTHON) -m venv $(VENV)
	test -f $(VENV)/.installed || $(BIN)/python -m pip install --quiet --upgrade "pip>=25.1"
	test -f $(VENV)/.installed || $(BIN)/python -m pip install --quiet --editable . --group docs
	touch $@

# The environment of a suite. The other one is made from it, so that `make -j suite test` runs one installation at a time.
$(VENV)/.suite: pyproject.toml
	$(PYTHON) -m venv $(VENV)
	$(BIN)/python -m pip install --quiet --editable ".[sim]"
	touch $@

# The complete environment: development tools, and ROS 2 where pip has it.
$(VENV)/.installed: $(VENV)/.suite
	$(BIN)/python -m pip install --quiet --upgrade "pip>=25.1"
	$(BIN)/python -m pip install --quiet --editable ".[sim]" --group dev
	$(MAKE) --no-print-directory ros2 || echo "no ROS 2 from pip for this Python: tests that need rclpy are skipped"
	touch $@

# rclpy and a middleware in an environment of its own: what it brings (lark-parser) would take the place of lark, and each
# Python of its environment starts twice. The tests see its modules, behind those of theirs.
ros2:
	$(PYTHON) -m venv --without-pip $(ROS)
	$(BIN)/python -m pip --python $(ROS)/bin/python install --quiet --group ros
	$(BIN)/python -m pip --python $(ROS)/bin/python uninstall --quiet --yes lark-parser
	$(ROS)/bin/python -c 'import sysconfig; print(sysconfig.get_path("purelib"))' \
	  > "$$($(BIN)/python -c 'import sysconfig; print(sysconfig.get_path("purelib"))')/ros2.pth"

clean:
	rm -rf $(VENV) docs/_build dist .pytest_cache .mypy_cache .ruff_cache .hypothesis hri-report hri-campaign hri-campaign.db* hri-experiment hri-agreement hri-adequacy hri-false-alarms hri-engines hri-closure
