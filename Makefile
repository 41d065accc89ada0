# What a maintainer types. `make setup` once; PYTHON=python3.12 chooses another interpreter.
PYTHON ?= python3
BIN := .venv/bin
NEWEST ?= 3.14
BASE ?= $(shell git describe --tags --abbrev=0 2>/dev/null)

.PHONY: setup test lowest newest slow coverage mutants check docs flow bench evidence peers evidence-check

setup: ## an environment with everything, and the hooks
	$(PYTHON) -m venv .venv
	$(BIN)/pip install -q -e '.[test,docs,dev]'
	$(BIN)/pre-commit install

test: ## the default tests
	$(BIN)/python -m pytest -q -n 2

lowest: ## the default tests with the lowest versions of all direct dependencies
	uv venv -q --clear -p 3.11 build/lowest
	uv pip compile -q --resolution lowest-direct -p 3.11 --extra test --extra xarray --extra topography --extra explore \
		pyproject.toml -o build/lowest.txt
	uv pip install -q -p build/lowest -r build/lowest.txt && uv pip install -q -p build/lowest --no-deps -e .
	build/lowest/bin/python -m pytest -q -n 2

newest: ## the default tests with the newest versions of all dependencies; NEWEST=3.13 chooses another Python
	uv venv -q --clear -p $(NEWEST) build/newest
	uv pip install -q --upgrade -p build/newest -e '.[test,explore]'
	build/newest/bin/python -m pytest -q -n 2

slow: ## the slow ones
	$(BIN)/python -m pytest -q -m slow

coverage: ## which lines the default tests run, kernels included
	PATH="$(CURDIR)/$(BIN):$$PATH" bash tests/coverage.sh

mutants: ## whether the tests notice errors planted in formulas and kernels; half an hour
	$(BIN)/python tests/mutate.py

check: ## style and types
	$(BIN)/ruff check . && $(BIN)/ruff format --check . && $(BIN)/mypy && $(BIN)/mypy --strict docs/examples

docs: ## the site, in build/site
	$(BIN)/python -m sphinx -qW --keep-going docs build/site

flow: ## the picture and the table of the modules
	$(BIN)/python docs/flow.py

bench: ## this tree against the last tag, or BASE=COMMIT, both measured now on this machine
	PATH="$(CURDIR)/$(BIN):$$PATH" benchmarks/against.sh "$(BASE)"

# single-threaded: their CPU times are those of one core
MEASURE := OMP_NUM_THREADS=1 OPENBLAS_NUM_THREADS=1 $(BIN)/python
evidence: ## every file of docs/evidence, then tables and figures; goes on after a stop; hours after `rm -r runs`
	$(BIN)/pip install -q '.[peers]'
	$(MEASURE) experiments/flash_vs_speed.py --evidence
	$(MEASURE) experiments/tutorial.py --evidence
	$(MEASURE) experiments/partition.py --evidence
	$(MEASURE) experiments/finite_contact.py --evidence
	$(MEASURE) experiments/paper.py --evidence
	$(MEASURE) experiments/inverse.py --evidence
	$(MEASURE) experiments/uncertainty.py --evidence
	$(MEASURE) experiments/unloading.py --evidence
	$(MEASURE) experiments/multiscale.py --evidence
	$(MEASURE) experiments/skin.py --evidence
	$(MEASURE) experiments/two_bodies.py --evidence
	$(MEASURE) experiments/reactions.py --evidence
	$(MEASURE) experiments/worked_reactions.py --evidence
	$(MEASURE) experiments/few_spots.py --evidence
	$(MEASURE) experiments/few_spots_seen.py --evidence
	$(MEASURE) experiments/sliding_reactions.py --evidence
	$(MEASURE) experiments/two_bodies_points.py --evidence
	$(MEASURE) experiments/sliding_distance.py --evidence
	$(MEASURE) benchmarks/sliding.py --continued --evidence
	$(MEASURE) experiments/loads.py --evidence
	$(MEASURE) experiments/camera.py --evidence
	$(MEASURE) experiments/camera_law.py --evidence
	$(MEASURE) experiments/camera_exposure.py --evidence
	$(MEASURE) experiments/lay.py --evidence
	$(MEASURE) experiments/lay_camera.py --evidence
	$(MEASURE) experiments/lay_waves.py --evidence
	$(MEASURE) experiments/yielding.py --evidence
	$(MEASURE) experiments/yielding_gaps.py --evidence
	$(MEASURE) experiments/sliding_yielding.py --evidence
	$(MEASURE) experiments/scans.py --evidence
	$(MEASURE) experiments/pressed_maps.py --evidence
	$(MEASURE) experiments/pictures.py --evidence
	$(MEASURE) experiments/accuracy_vs_cost.py contact --evidence
	$(MEASURE) experiments/validity.py --evidence
	$(MEASURE) experiments/tolerance.py --evidence
	$(MEASURE) experiments/coverage.py --evidence
	$(MEASURE) experiments/coverage.py --drawn 15060 --evidence
	$(MEASURE) experiments/coverage.py --materials 571 --evidence
	$(MEASURE) experiments/coverage.py --lays 6300 --evidence
	$(MEASURE) experiments/cut_ladders.py --evidence
	$(MEASURE) experiments/pixel_falls.py --evidence
	$(MEASURE) experiments/trends.py --evidence
	$(MEASURE) benchmarks/chain.py --evidence
	$(MEASURE) benchmarks/skin.py --evidence
	$(MEASURE) benchmarks/heat.py --points 0 --evidence
	$(MEASURE) benchmarks/reactions.py --evidence
	$(MEASURE) experiments/chain_ways.py --evidence
	$(MEASURE) experiments/contact_solvers.py --evidence
	$(MEASURE) experiments/heat_methods.py --evidence
	$(MEASURE) experiments/where_methods_fail.py --resume --evidence
	$(BIN)/python docs/evidence.py

SCENES := "yielding 1" demo steel-1.2GPa "yielding 3" "low H" "unlike faces" elastic
peers: ## cost beside other packages, solvers and scripts, all times new: an idle machine, some hours
	$(BIN)/pip install -q '.[peers]'
	rm -rf runs/chain runs/chain_ways runs/contact_solvers runs/over_script
	$(MEASURE) benchmarks/chain.py --times 3 --scenes $(SCENES) --targets 0.03 0.01 -o runs/over_script
	$(MEASURE) benchmarks/chain.py --evidence
	$(MEASURE) experiments/chain_ways.py --evidence
	$(MEASURE) experiments/contact_solvers.py --evidence
	$(BIN)/python docs/evidence.py

evidence-check: ## whether pages and figures are those of docs/evidence, to the printed digit
	$(BIN)/python docs/evidence.py --check
