# Every target installs what it needs into .venv first: any of them can be the first command of a newcomer.
PYTHON ?= $(shell command -v python3.11 || command -v python3)
VENV := .venv
BIN := $(VENV)/bin
SAMPLE ?= 60
# numba's kernels and the tests' bytecode, once: two workers and a dozen programs would each compile them anew
COMPILE = rm -rf $(VENV)/compiled; $(BIN)/topomap optimize examples/graphs/block-doubtful.g2o --out $(VENV)/compiled/graph >/dev/null & \
	$(BIN)/topomap run tests/helpers/den.toml --out $(VENV)/compiled/run --force >/dev/null & \
	$(BIN)/pytest --collect-only >/dev/null; wait
unexport PYTHONDONTWRITEBYTECODE
PIP := $(BIN)/python -m pip --disable-pip-version-check --quiet

.PHONY: demo test lint bench mutate results lock clean
.DEFAULT_GOAL := demo

demo: $(VENV)/.run ## drive, map, close the loop, go home; prints where the report and the log lie
	$(BIN)/topomap run room-corridor --out runs/demo --force

test: $(VENV)/.test ## everything .ci/run checks: lint beside the tests, which leave a tenth of two cores idle
	@$(MAKE) --no-print-directory lint >$(VENV)/lint.log 2>&1 & lint=$$!; \
	$(BIN)/pytest -n 2; tests=$$?; wait $$lint; lint=$$?; cat $(VENV)/lint.log; exit $$((tests | lint))

lint: $(VENV)/.test
	$(BIN)/ruff check .
	$(BIN)/ruff format --check .
	$(BIN)/mypy
	$(BIN)/lint-imports

bench: $(VENV)/.bench ## slow studies and timings; writes bench.json
	$(BIN)/python -m tests.benchmarks
	$(BIN)/python -m tests.fuzz
	$(BIN)/pytest -n 2 -m slow

mutate: $(VENV)/.test ## a sample of small mistakes, each to be noticed by a test; all of them: make mutate SAMPLE=0
	$(BIN)/python -m tests.mutation --sample $(SAMPLE)

KEEP := --keep docs/results
RINGS := examples/worlds/tree.toml,examples/worlds/cubicles.toml,examples/worlds/warehouse.toml,examples/worlds/figure_eight.toml
DISTURBED := "turned,moved,carried,carried late,blind ranges,dead odometry,very noisy odometry"
KEEP_SWEEP = ( echo "\# topomap $(1)"; cat runs/$(2)/sweep.csv ) > docs/results/$(2).csv
WEATHER := sweep hall room-corridor office-loop --seeds 0-4 --variants examples/sweeps/real-weather.toml
STRENGTH := sweep room-corridor --seeds 0-2 --variants examples/sweeps/real-weather-strength.toml
TILT := sweep hall room-corridor office-loop --seeds 0-9 --variants examples/sweeps/tilt.toml
LOOK_ALIKES := --seeds 0-4 --variants examples/sweeps/look-alikes.toml --set stack.mission.then=stop
ALIKE := sweep examples/worlds/two-corridors.toml examples/worlds/tree.toml hall $(LOOK_ALIKES)
ALIKE_RINGS := sweep examples/worlds/cubicles.toml examples/worlds/figure_eight.toml examples/worlds/warehouse.toml \
	$(LOOK_ALIKES) --set sim.driver.laps=2
ROOMS := a1original,screen,arboreal,hall1,ourlab,cylinders

results: $(VENV)/.test ## the figures of docs/results, docs/THESIS.md and docs/ROBUST.md anew: hours; GRIDS=, DRIVES=folders of panoramas, TOPOMAP_DATA=recorded data
	for c in given A6; do $(BIN)/topomap bench homing --env $(ROOMS) --seeds 0-4 --every 16 --compass $$c \
		--starts 0 --no-pictures $(KEEP)/homing.csv || exit 1; done
	for g in $(GRIDS); do for w in 0.1 0.3 0.5 0.7; do $(BIN)/topomap bench homing --grid $$g --within $$w \
		--no-pictures $(KEEP)/grids.csv || exit 1; done; done
	$(BIN)/topomap sweep room-corridor office-loop --seeds 0-9 --set stack.mission.then=stop --out runs/loop
	$(BIN)/topomap sweep office-loop --seeds 0-9 --variants examples/sweeps/standing.toml --set stack.mission.then=stop --out runs/standing
	$(BIN)/topomap bench loop-rule $$(find runs/loop -name run.mcap | sort) $(KEEP)/loop-rule.csv
	$(BIN)/topomap bench spacing $(KEEP)/spacing.csv
	$(BIN)/topomap bench study all --seeds 0-1 --every 8 $(KEEP)/studies.csv
	$(BIN)/topomap bench study hall-mission --seeds 0-9 $(KEEP)/studies.csv
	$(BIN)/topomap bench mission
	for d in $(DRIVES); do $(BIN)/topomap bench drive $$d --draws 3 --scale 1 --scale 3 --scale 10 \
		--every 1 --every 2 --every 4 $(KEEP)/drives.csv || exit 1; done
	$(BIN)/topomap $(WEATHER) --out runs/real-weather
	$(call KEEP_SWEEP,$(WEATHER),real-weather)
	cp runs/real-weather/matrix.png docs/results/real-weather.png
	$(BIN)/topomap $(STRENGTH) --out runs/real-weather-strength
	$(call KEEP_SWEEP,$(STRENGTH),real-weather-strength)
	cp runs/real-weather-strength/matrix.png docs/results/real-weather-strength.png
	$(BIN)/topomap $(TILT) --out runs/tilt
	$(call KEEP_SWEEP,$(TILT),tilt)
	$(BIN)/topomap $(ALIKE) --out runs/alike
	$(BIN)/topomap $(ALIKE_RINGS) --out runs/alike-rings
	( echo "# topomap $(ALIKE)"; echo "# topomap $(ALIKE_RINGS)"; cat runs/alike/sweep.csv; \
		tail -n +2 runs/alike-rings/sweep.csv ) > docs/results/look-alikes.csv
	$(BIN)/topomap bench breaks $(KEEP)/breaks.csv
	$(BIN)/topomap bench faults $(KEEP)/faults.csv
	$(BIN)/topomap bench journeys --worlds room-corridor,hall --seeds 20-22 --kinds $(DISTURBED) --count 2 --goal any \
		$(KEEP)/journeys.csv
	$(BIN)/topomap bench journeys --worlds office-loop --seeds 20-24 --kinds $(DISTURBED) $(KEEP)/journeys.csv
	$(BIN)/topomap bench journeys --worlds office-loop --seeds 20-24 --kinds $(DISTURBED) \
		--set stack.mapper.snapshots.view=90x12x4 $(KEEP)/journeys.csv
	$(BIN)/topomap bench journeys --worlds hall,office-loop --seeds 0-9 --textures 0-2 --set sim.driver.laps=0.5 $(KEEP)/journeys.csv
	$(BIN)/topomap bench journeys --worlds room-corridor,$(RINGS) --seeds 0-9 --textures 0-2 $(KEEP)/journeys.csv
	$(BIN)/topomap bench sessions --worlds hall,office-loop --seeds 0-4 --laps 10 $(KEEP)/sessions.csv
	$(BIN)/topomap bench kidnapped examples/worlds/two-corridors.toml,office-loop --seeds 60-64 $(KEEP)/kidnapped.csv
	$(BIN)/topomap bench graphs --graphs CSAIL,intel --peers DCS,GNC,Huber $(KEEP)/graphs.csv
	$(BIN)/topomap bench graphs --graphs manhattanOlson3500 --peers DCS,GNC,Huber $(KEEP)/graphs.csv
	$(BIN)/topomap bench graphs --graphs w10000 --peers DCS,GNC,Huber --seeds 0-2 $(KEEP)/graphs.csv
	$(BIN)/python -m tests.fuzz $(KEEP)/fuzz.csv
	$(BIN)/python -m tests.mutation --named
	$(BIN)/python -m tests.mutation --sample 150 --out docs/results/mutation.json

lock: $(VENV)/.bench ## constraints.txt from what is installed, after a change of pyproject.toml and a green `make test`
	( head -1 constraints.txt; $(BIN)/python -m pip list --format=freeze | grep -Ev '^(topomap|pip|setuptools|wheel)=' ) > .lock
	mv .lock constraints.txt

clean:
	rm -rf $(VENV) build *.egg-info

$(BIN)/python:
	@$(PYTHON) -c 'import sys; sys.exit(sys.version_info < (3, 11))' \
		|| { echo "topomap needs Python >= 3.11; call: make PYTHON=/path/to/python3.11"; exit 1; }
	$(PYTHON) -m venv $(VENV)

$(VENV)/.run: pyproject.toml constraints.txt | $(BIN)/python
	$(PIP) install -c constraints.txt -e .
	@touch $@

$(VENV)/.test: pyproject.toml constraints.txt | $(BIN)/python
	$(PIP) install -c constraints.txt -e '.[test]'
	$(COMPILE)
	@touch $@ $(VENV)/.run

$(VENV)/.bench: pyproject.toml constraints.txt | $(BIN)/python
	$(PIP) install -c constraints.txt -e '.[test,bench]'
	$(COMPILE)
	@touch $@ $(VENV)/.test $(VENV)/.run
