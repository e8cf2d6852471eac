# `make demo` and `make test` are all a newcomer needs: both set up .venv on first use.

PYTHON ?= $(shell command -v python3.11 || command -v python3)
VENV := .venv
BIN := $(VENV)/bin
DEMO := build/demo
PIP := --quiet --disable-pip-version-check --no-compile
# Tests start many processes: bytecode is written once, by the first that imports something.
unexport PYTHONDONTWRITEBYTECODE

.PHONY: demo gallery test check format lint types pyright imports drift pytest interpreters bench clean

demo: $(VENV)/demo.stamp
	$(BIN)/rtgen generate
	mkdir -p $(DEMO)
	$(BIN)/rtgen run specs/navigation/rh3_goal.xml --plot $(DEMO)/goal.svg --csv $(DEMO)/goal.csv
	$(BIN)/rtgen run specs/navigation/rh3_path.xml --plot $(DEMO)/path.svg --csv $(DEMO)/path.csv
	$(BIN)/rtgen graph specs/navigation/rh3_goal.xml -o $(DEMO)/wiring.svg
	@echo "Pictures: $(DEMO)/goal.svg $(DEMO)/path.svg $(DEMO)/wiring.svg; trajectories: $(DEMO)/goal.csv $(DEMO)/path.csv"

# docs/gallery.md with its diagrams and pictures.
gallery: $(VENV)/test.stamp
	$(BIN)/python tests/reference/gallery.py

test: $(VENV)/test.stamp
	$(MAKE) --no-print-directory -j 2 lint types imports drift
	$(MAKE) --no-print-directory pytest
	$(MAKE) --no-print-directory interpreters

lint: $(VENV)/test.stamp
	$(BIN)/black --check --quiet src tests benchmarks
	$(BIN)/ruff check src tests benchmarks

types: mypy-3.11 mypy-3.12 mypy-3.13 pyright

mypy-%: $(VENV)/test.stamp
	$(BIN)/mypy --python-version $* src generated

pyright: $(VENV)/test.stamp
	PYRIGHT_PYTHON_IGNORE_WARNINGS=1 $(BIN)/pyright --pythonpath $(BIN)/python

imports: $(VENV)/test.stamp
	$(BIN)/lint-imports

drift: $(VENV)/test.stamp
	$(BIN)/rtgen check

# Each worker begins with a half of the files, so what tests of a file share is made once.
pytest: $(VENV)/test.stamp
	$(BIN)/pytest -n 2 --dist worksteal

# The fast tests again on each other interpreter that this machine has, those with peers left out;
# the newest one measures the coverage.
interpreters: $(VENV)/test.stamp
	$(BIN)/python tests/interpreters.py

bench: $(VENV)/bench.stamp
	for script in benchmarks/*.py; do $(BIN)/python $$script || exit 1; done

format: $(VENV)/test.stamp
	$(BIN)/black --quiet src tests benchmarks
	$(BIN)/ruff check --fix src tests benchmarks

clean:
	rm -rf build dist $(VENV)

$(VENV)/bin/python:
	$(PYTHON) -m venv $(VENV)

$(VENV)/demo.stamp: pyproject.toml $(wildcard grammars/*.lark) | $(VENV)/bin/python
	$(BIN)/python -m pip install $(PIP) --editable ".[plot]"
	touch $@

$(VENV)/test.stamp: pyproject.toml $(wildcard grammars/*.lark) | $(VENV)/bin/python
	$(BIN)/python -m pip install $(PIP) --editable ".[plot,test]"
	touch $@

$(VENV)/bench.stamp: pyproject.toml $(wildcard grammars/*.lark) | $(VENV)/bin/python
	$(BIN)/python -m pip install $(PIP) --editable ".[plot,test,bench]"
	touch $@
