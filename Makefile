# make run    set up .venv, then fly the default slew
# make test   set up .venv, then run all tests
# make check  set up .venv, then format, lint and type-check
# make bench  set up .venv, then time the solver, a closed-loop flight and the plant
PYTHON ?= python3
VENV := .venv
BIN := $(VENV)/bin

.DEFAULT_GOAL := help
.PHONY: help setup run test test-slow check bench clean

help:
	@sed -n 's/^# //p' Makefile

setup: $(VENV)/ready

$(VENV)/ready: pyproject.toml constraints.txt
	$(PYTHON) -c 'import sys; sys.exit(sys.version_info < (3, 11) and "Python 3.11 or newer is needed, this is " + sys.version)'
	$(PYTHON) -m venv $(VENV)
	$(BIN)/python -m pip install --quiet --disable-pip-version-check -c constraints.txt -e '.[dev,cluster]'
	touch $@

run: setup
	$(BIN)/python -m simsat.run

test: setup
	$(BIN)/python -m pytest -n 2 -m 'not slow'

bench: setup
	$(BIN)/python -m tests.bench.solver
	$(BIN)/python -m tests.bench.closed_loop
	$(BIN)/python -m tests.bench.plant_speed

test-slow: setup
	$(BIN)/python -m pytest

check: setup
	$(BIN)/ruff format --check .
	$(BIN)/ruff check .
	$(BIN)/mypy

clean:
	rm -rf $(VENV) .mypy_cache .ruff_cache .pytest_cache *.egg-info
