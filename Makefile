# Farhand's commands; each does its own set-up in .venv on a machine with Python 3.11 or newer.
PYTHON ?= python3
BIN := .venv/bin
READY := .venv/ready
export PYTHONDONTWRITEBYTECODE :=  # every process would compile all modules again

READERS := build/dataset-readers
TYPESCRIPT := node_modules/ready

.PHONY: loopback learned franka arms eye dataset-readers test test-lab long faults check check-page bench fuzz results

loopback: $(READY)  ## both sites on this machine, with a simulated operator and a simulated cell
	@$(BIN)/farhand loopback $(ARGS)

learned: $(READY)  ## runtime and models of the tracker for ordinary rooms, which the other commands do without
	@$(BIN)/python -m pip install --quiet --disable-pip-version-check --constraint constraints.txt --editable '.[learned]'
	@$(BIN)/farhand models install
	@echo 'Compiling the tracker for rooms (once, up to two minutes) ...'
	@$(BIN)/python -m local_site.runtime.warm_up learned

franka: $(READY)  ## the client of the FR3 and a simulator that speaks its protocol, which the other commands do without
	@$(BIN)/python -m pip install --quiet --disable-pip-version-check --constraint constraints.txt --editable '.[franka-sim]'

arms: $(READY)  ## files of several makers' arms, as they publish them, for the tests of the import
	@$(BIN)/python -m pip install --quiet --disable-pip-version-check --constraint constraints.txt --editable '.[arms]'

eye: $(READY)  ## what the eye's networks are trained with, which the other commands do without
	@$(BIN)/python -m pip install --quiet --disable-pip-version-check --constraint constraints.txt --editable './lab[eye]'

dataset-readers: $(READERS)/ready  ## programs of others that read exported datasets, in an environment of their own, for the tests

test: $(READY)  ## the quick tests, two at once
	@$(BIN)/python -m pytest --numprocesses 2 --no-loadscope-reorder --ignore tests/lab $(ARGS)

test-lab: $(READY)  ## the tests of the lab, which measures Farhand
	@$(BIN)/python -m pytest --numprocesses 2 --no-loadscope-reorder $(ARGS) tests/lab

long: $(READY)  ## the tests that take long
	@$(BIN)/python -m pytest -m long --numprocesses 2 --no-loadscope-reorder --hypothesis-profile "other examples" $(ARGS)

faults: $(READY)  ## every fault of the table on both sites, reported in build/faults.json and build/faults/report.html
	@$(BIN)/python -m pytest -m faults $(ARGS) tests/faults

check: $(READY)  ## the static checks
	@$(BIN)/ruff check .
	@$(BIN)/ruff format --check .
	@$(BIN)/mypy
	@$(BIN)/lint-imports
	@$(MAKE) --no-print-directory check-page

ifneq ($(and $(shell command -v node),$(shell command -v npm)),)
check-page: $(TYPESCRIPT)  ## the types of the operator's page, and the tests of its modules without a browser
	@node_modules/.bin/tsc
	@node_modules/.bin/tsc --project tsconfig.worker.json
	@node --test --test-reporter=dot tests/page/*.test.js
else
check-page:
	@echo "The operator's page is not checked: that needs Node 20 or newer, and npm; on Debian: apt-get install nodejs npm"
endif

bench: $(READY)  ## side-by-side measurements, written to build/bench.json
	@$(BIN)/python -m bench $(ARGS)

results: $(READY)  ## every experiment in full, hours of it but for the trials in docs/results, and what comes of it into docs
	@mkdir -p build/results docs/results
	@test -e build/results/trials.jsonl || test ! -e docs/results/trials.jsonl || cp docs/results/trials.jsonl build/results/
	@$(BIN)/farhand experiment all --out build/results
	@cp build/results/results.md docs/results.md
	@cp build/results/trials.jsonl docs/results/
	@cp build/results/network/network.png build/results/placing/placing.png docs/

fuzz: $(READY)  ## a million hostile payloads for the codec
	@$(BIN)/python -m bench fuzz

$(READERS)/ready: constraints.txt Makefile
	@$(PYTHON) -m venv $(READERS)
	@$(READERS)/bin/python -m pip install --quiet --disable-pip-version-check --constraint constraints.txt lerobot-doctor==0.2.0 pandas==3.1.1 rerun-sdk==0.41.0
	@touch $@

$(TYPESCRIPT): package.json package-lock.json
	@npm ci --silent --no-audit --no-fund
	@touch $@

$(READY): constraints.txt pyproject.toml lab/pyproject.toml
	@$(PYTHON) -c 'import sys; sys.exit("Farhand needs Python 3.11 or newer, this is %d.%d: make PYTHON=/path/to/python3.11" % sys.version_info[:2] if sys.version_info < (3, 11) else 0)'
	@$(PYTHON) -c 'import ensurepip' 2>/dev/null || { echo 'Python lacks its venv module; on Debian: apt-get install python3-venv'; exit 1; }
	@echo 'Setting up .venv (once) ...'
	@$(PYTHON) -m venv .venv
	@$(BIN)/python -m pip install --quiet --disable-pip-version-check --constraint constraints.txt --editable '.[dev]' --editable ./lab
	@echo 'Compiling the tracker (once, up to a minute) ...'
	@$(BIN)/python -m local_site.runtime.warm_up
	@touch $@
