# `make demo` and `make test` are all a newcomer needs; both set up what they use.
PYTHON ?= python3.11
VENV := .venv
BIN := $(VENV)/bin
STAMPS := .stamps
EXTRAS ?= all,dev
# Tests at a time. Those in real time run alone, in the end.
WORKERS ?= 2
comma := ,
# One stamp a set of extras: another set, or a changed lock, installs again.
STAMP := $(STAMPS)/$(subst $(comma),-,$(EXTRAS))

.PHONY: help demo up test check bench clean setup format

help:
	@echo "make demo    set up, and play the main job in the simulator"
	@echo "make up      set up, and run the system until Ctrl-C (operator's page: http://127.0.0.1:8080)"
	@echo "make test    set up, and run the tests"
	@echo "make check   set up, and run formatter, linter, types and import rules"
	@echo "make bench   set up, and run the demo in lock step on 5 random layouts"
	@echo "make clean   remove what make made (not runs/)"

setup: $(STAMP)

$(STAMP): pyproject.toml constraints.txt deploy/setup.sh
	@PYTHON="$(PYTHON)" VENV="$(VENV)" EXTRAS="$(EXTRAS)" bash deploy/setup.sh
	@mkdir -p $(STAMPS) && touch $@

demo: $(STAMP)
	$(BIN)/w2c demo

up: $(STAMP)
	$(BIN)/w2c up

# Two workers, each with its threads, must not spin for each other's cores.
test: export OMP_WAIT_POLICY = PASSIVE
test: export OPENBLAS_NUM_THREADS = 1
test: $(STAMP)
	$(BIN)/python -m pytest -n $(WORKERS) --dist loadfile --no-loadscope-reorder

check: $(STAMP)
	$(BIN)/ruff format --check .
	$(BIN)/ruff check .
	$(BIN)/mypy
	$(BIN)/lint-imports

bench: $(STAMP)
	$(BIN)/w2c bench demo --seeds 5

format: $(STAMP)
	$(BIN)/ruff format .
	$(BIN)/ruff check --fix .

clean:
	rm -rf $(VENV) .wheels $(STAMPS) .mypy_cache .ruff_cache .pytest_cache .hypothesis .import_linter_cache
