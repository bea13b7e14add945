# Everything happens in an environment of its own. constraints.txt has the versions; of those `make lock` makes run.lock,
# test.lock and bench.lock with the hashes of their files, and what has another hash is not installed.
PYTHON ?= python3
VENV   := .venv
BIN    := $(VENV)/bin
# Not compiled ahead: that takes half of the time, and most modules are never imported.
PIP    := PIP_DISABLE_PIP_VERSION_CHECK=1 $(BIN)/python -m pip install --quiet --no-compile
LOCKED := $(PIP) --require-hashes -r
ITSELF := $(PIP) --no-deps --no-build-isolation -e .
EXTRAS := --extra opencl --extra serial --extra tables --extra fem --extra video --extra texture --extra scale \
	--extra studio --extra notebook --extra docs
COMPILE = printf 'pip\nhatchling\neditables\n' | uv pip compile pyproject.toml - -c constraints.txt --universal \
	--python-version 3.11 --generate-hashes --no-annotate --no-header --quiet
SCENE  ?= examples/scenes/grip.toml

MARKED := not slow
LOWEST := out/lowest/bin

.PHONY: run test test-all check lowest docs bench accuracy gpu hard-cases scaling endurance format clean lock

run: $(VENV)/.run            ## the main job: two fingers grip, lift, let slip and release
	$(BIN)/tactile run $(SCENE) -o out/$(basename $(notdir $(SCENE))) --replace

# Tests start hundreds of processes: each would compile every module anew where the environment forbids to keep them.
# Threads of OpenBLAS that wait for a core turn round and round: beside others they take ten times as long as one alone.
# The type checker uses one core for a minute, so lint and types run at the same time as the tests.
test: $(VENV)/.test          ## lint, types, tests
	$(MAKE) --no-print-directory check & checked=$$!; \
	PYTHONDONTWRITEBYTECODE= OMP_WAIT_POLICY=passive OPENBLAS_NUM_THREADS=1 $(BIN)/python -m pytest -n auto --dist worksteal -m "$(MARKED)"; \
	tested=$$?; wait $$checked && exit $$tested

test-all: MARKED :=          ## the same with long checks: pages in Chromium, killed runs, layers, meshes
test-all: test

check: $(VENV)/.test
	$(BIN)/ruff format --check .
	$(BIN)/ruff check .
	$(BIN)/mypy
	@if command -v tsc >/dev/null; then tsc -p tests/cnnsim/studio/tsconfig.json; else echo 'tsc is not there: the pages are not type-checked'; fi

lowest:                      ## main jobs with the lowest versions that pyproject.toml allows; wants uv
	uv venv --quiet --clear --python 3.11 out/lowest
	uv pip install --quiet --python $(LOWEST)/python --resolution lowest-direct -e ".[opencl,serial,fem,video,texture,scale]"
	rm -rf out/lowest/jobs && mkdir out/lowest/jobs
	$(LOWEST)/cnnsim run edge examples/scan.png -o out/lowest/jobs/edge.png
	CNNSIM_POCL_PROCESSOR=auto $(LOWEST)/cnnsim run hole-filler examples/scan.png -o out/lowest/jobs/opencl.png --backend opencl
	$(LOWEST)/cnnsim run hole-filler examples/scan.png -o out/lowest/jobs/stored.png --store out/lowest/jobs/store --workers 1
	$(LOWEST)/cnnsim trace edge examples/scan.png -o out/lowest/jobs/trace.png
	$(LOWEST)/tactile convert examples/grasp.npz out/lowest/jobs/grasp.mcap
	$(LOWEST)/tactile convert out/lowest/jobs/grasp.mcap out/lowest/jobs/grasp.parquet
	$(LOWEST)/tactile run $(SCENE) -o out/lowest/jobs/grip

bench: $(VENV)/.bench        ## speed, as ratios to peers measured in the same run
	$(BIN)/python -m tests.benchmarks -o out/bench

gpu: $(VENV)/.test          ## the OpenCL backend on the GPU: tests, then speed with installed peers; elsewhere: make gpu GPU=--any-device
	$(BIN)/python -m tests.benchmarks.gpu $(GPU) -o out/gpu

endurance: $(VENV)/.test     ## long runs and fuzzing, into docs/reliability.md; short: make endurance ENDURANCE=--short
	$(BIN)/python -m tests.fuzz.report $(ENDURANCE) -o docs/reliability.md

accuracy: $(VENV)/.test     ## what accuracy costs in time: docs/accuracy.md, its figures and diagrams
	$(BIN)/python -m tests.benchmarks.accuracy -o docs

hard-cases: $(VENV)/.test   ## exact answers of hard cases against ours and the naive form: docs/hard-cases.md
	$(BIN)/python -m tests.hard_cases -o docs

scaling: $(VENV)/.test      ## arrays of taxels, grids on the disk, plans on paper: docs/scaling.md; short: make scaling SCALING=--short
	$(BIN)/python -m tests.benchmarks.scaling $(SCALING) -o docs

docs: $(VENV)/.test          ## the site, into out/site/index.html
	$(BIN)/python -m sphinx -W --keep-going -q -b html docs out/site
	@echo "-> out/site/index.html"

format: $(VENV)/.test
	$(BIN)/ruff format .
	$(BIN)/ruff check --fix .

clean:
	rm -rf $(VENV) out

$(BIN)/python:
	$(PYTHON) -m venv $(VENV)

$(VENV)/.run: pyproject.toml run.lock | $(BIN)/python
	$(LOCKED) run.lock
	$(ITSELF)
	touch $@

$(VENV)/.test: pyproject.toml test.lock | $(BIN)/python
	$(LOCKED) test.lock
	$(ITSELF)
	touch $@ $(VENV)/.run

$(VENV)/.bench: $(VENV)/.test bench.lock    # with the peers: gigabytes
	$(LOCKED) bench.lock
	touch $@

lock:                        ## after a change of constraints.txt or pyproject.toml; wants uv
	$(COMPILE) -o run.lock
	$(COMPILE) $(EXTRAS) --extra test -o test.lock
	$(COMPILE) $(EXTRAS) --extra test --extra bench -o bench.lock
