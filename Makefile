# Everything happens in an environment of its own, made from the pinned versions of constraints.txt.
PYTHON ?= python3
VENV   := .venv
BIN    := $(VENV)/bin
PIP    := PIP_CONSTRAINT=constraints.txt PIP_DISABLE_PIP_VERSION_CHECK=1 $(BIN)/pip install --quiet
SCENE  ?= examples/scenes/grip.toml

.PHONY: run test check bench format clean

run: $(VENV)/.run            ## the main job: two fingers grip, lift, let slip and release
	$(BIN)/tactile run $(SCENE) -o out/$(basename $(notdir $(SCENE)))

test: $(VENV)/.test check    ## lint, types, tests
	OMP_WAIT_POLICY=passive $(BIN)/python -m pytest -n auto --dist worksteal

check: $(VENV)/.test
	$(BIN)/ruff format --check .
	$(BIN)/ruff check .
	$(BIN)/mypy

bench: $(VENV)/.bench        ## speed, as ratios to peers measured in the same run
	$(BIN)/python -m tests.benchmarks -o out/bench

format: $(VENV)/.test
	$(BIN)/ruff format .
	$(BIN)/ruff check --fix .

clean:
	rm -rf $(VENV) out

$(BIN)/python:
	$(PYTHON) -m venv $(VENV)

$(VENV)/.run: pyproject.toml constraints.txt | $(BIN)/python
	$(PIP) -e .
	touch $@

$(VENV)/.test: pyproject.toml constraints.txt | $(BIN)/python
	$(PIP) -e '.[test,opencl,serial,fem,video,texture]'
	touch $@ $(VENV)/.run

$(VENV)/.bench: $(VENV)/.test
	$(PIP) -e '.[test,opencl,serial,fem,video,texture,bench]'
	touch $@
