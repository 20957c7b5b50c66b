# make run    set up .venv for flying, then fly the default slew
# make test   add to .venv what training and testing need, then run all tests
# make check  the same, then format, lint and type-check
# make bench  the same, then time the solver, a closed-loop flight and the plant
# make setup  only set up .venv, for everything
PYTHON ?= python3
VENV := .venv
BIN := $(VENV)/bin
SHELL := bash
.SHELLFLAGS := -o pipefail -ec

# Stamps: newer than pyproject.toml and constraints.txt where .venv holds what they ask for.
FLYING := $(VENV)/flying
TESTING := $(VENV)/testing
UNFINISHED := $(VENV)/unfinished

# They count for nothing after an install that broke off, or once Python itself is gone.
$(shell { [ ! -e $(UNFINISHED) ] && $(BIN)/python -c ''; } 2>/dev/null || rm -f $(FLYING) $(TESTING))

.DEFAULT_GOAL := help
.PHONY: help setup run test test-slow check bench clean

help:
	@sed -n 's/^# \(make\)/\1/p' Makefile

setup: $(TESTING)

$(FLYING): pyproject.toml constraints.txt
	@echo 'Setting up $(VENV) for flying (a minute once, 1.5 GB):'
	$(call install,.)
	@touch $(FLYING)

$(TESTING): pyproject.toml constraints.txt
	@echo 'Setting up $(VENV) for flying, training and testing (two minutes once, 2.5 GB):'
	$(call install,.[learning$(,)gym$(,)cluster$(,)dev])
	@touch $(FLYING) $(TESTING)

# Shows a line for each package that arrives; pip's warnings and errors come through as they are.
, := ,
define install
	@$(PYTHON) -c 'import sys; sys.exit(sys.version_info < (3, 11) and "Python 3.11 or newer is needed, this is " + sys.version)'
	@if [ -e $(UNFINISHED) ] || ! $(BIN)/python -m pip --version >/dev/null 2>&1; then \
		$(PYTHON) -m venv $$([ -e $(VENV)/pyvenv.cfg ] && echo --clear) $(VENV); fi
	@rm -f $(FLYING) $(TESTING); touch $(UNFINISHED)
	@$(BIN)/python -m pip install --disable-pip-version-check -c constraints.txt -e '$(1)' \
		| { grep --line-buffered -E '^ *(Downloading|Using cached|Processing|Installing)' || true; }
	@rm $(UNFINISHED)
endef

run: $(FLYING)
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
	rm -rf $(VENV) build .mypy_cache .ruff_cache .pytest_cache *.egg-info
