# Every target first sets up what it needs: .venv with the pinned packages, and system libraries. `make
# setup` brings what all need, `make run` and `make test` add the extras that only they do.
# It takes the newest supported Python that it finds, pyenv's included; a .venv that stands keeps
# its own. Another Python: make PYTHON=python3.12 test; another folder: make VENV=.venv-3.12 test

VENV ?= .venv
BIN := $(VENV)/bin
# Three on two cores, as live flights, servers and browsers wait for the clock. A worker that has crashed,
# or was ended because a test hung, is not started anew: xdist would have it run the same test again, up
# to eight times
WORKERS ?= 3
# Plugins are named, not found: pytest rewrites the asserts of every package that brings a plugin, which
# would compile all modules of the workbench a second time
PLUGINS = --disable-plugin-autoload -p pytest-qt -p xdist -p xdist.looponfail -p random_order \
	-p workbench.pytest_plugin
PYTEST = $(BIN)/pytest $(PLUGINS) --dist loadfile -n $(WORKERS) --max-worker-restart 0 $(PYTEST_OPTIONS)

# installs extras, where that is not done yet
SET_UP = python3 tools/set_up.py --venv $(VENV) $(if $(PYTHON),--python $(PYTHON))

.DEFAULT_GOAL := help
.PHONY: help setup test-setup run test types quick test-slow test-all format notebooks examples docs bench clean

help: ## show this list
	@sed -n 's/^\([a-z-]*\):[^#]*## \(.*\)/make \1|\2/p' Makefile | while IFS='|' read -r name what; \
	do printf '  %-16s %s\n' "$$name" "$$what"; done

setup: ## make .venv (1.1 GB) and check the system's libraries; redone only where something changed
	@command -v python3 >/dev/null || { echo "There is no python3 here to run the set-up with:" \
	"run \`sudo apt-get install python3-venv\`, or install another Python 3.11 to 3.13." >&2; exit 2; }
	@$(SET_UP)
	@$(BIN)/python tools/check_system.py

test-setup: setup
	@$(SET_UP) test

run: setup ## open the app; without a screen, fly the published steps and write out/
	@if [ -n "$$DISPLAY$$WAYLAND_DISPLAY" ]; then \
	$(SET_UP) app,gamepad,logs && $(BIN)/python tools/check_system.py && $(BIN)/workbench gui; \
	else $(BIN)/workbench reproduce --output out; fi

test quick test-slow: export QT_QPA_PLATFORM = offscreen
# the many processes that tests start load compiled modules, also where the shell asks for none
test quick test-slow: export PYTHONDONTWRITEBYTECODE =
test: test-setup ## lint, types, and the tests but the slow ones; 5 to 7 minutes on two cores
	$(BIN)/ruff check . && $(BIN)/ruff format --check .
	@$(MAKE) --no-print-directory --jobs 2 types quick

# the tests begin while the types are still being checked; if either fails, the other ends and `test` fails
types:
	$(BIN)/pyrefly check --python-interpreter-path $(BIN)/python
quick: $(VENV)/collected
	$(PYTEST) -m "not slow"
# before the first run one process compiles all tests, which takes three times as long as to collect
# them; workers that begin at once would all do so. What is wrong with a test is told by the run
$(VENV)/collected:
	@$(PYTEST) -n 0 --collect-only -qq -m "not slow" > /dev/null 2>&1; touch $@

test-slow: setup ## the slow tests: soaks, wheels, clusters, browsers, documents that fly
	@$(SET_UP) slow
	$(PYTEST) -m slow --durations 30

test-all: test test-slow ## both; 35 minutes on two cores

format: setup ## lay out the source and mend what the linter can
	$(BIN)/ruff check --fix .
	$(BIN)/ruff format .

notebooks: setup ## run the notebooks and store what they show; some minutes
	@$(SET_UP) slow
	$(BIN)/python tools/notebooks.py

examples: setup ## run the examples and store their pictures; two minutes
	$(BIN)/python tools/example_pictures.py

docs: setup ## make a site of the documentation, with a reference, in build/docs; fails on a broken link
	@$(SET_UP) docs
	QT_QPA_PLATFORM=offscreen $(BIN)/sphinx-build -q -W --keep-going -c docs . build/docs
	@echo "The site begins at build/docs/README.html"

bench: setup ## measure, beside other simulators, and write docs/performance.md; half an hour
	@$(SET_UP) bench
	$(BIN)/python benchmarks/run.py --write

clean: ## remove .venv, build leftovers and caches; out/ stays
	rm -rf .venv .venv-* build dist .pytest_cache .ruff_cache
	find . -name __pycache__ -type d -prune -exec rm -rf {} +
