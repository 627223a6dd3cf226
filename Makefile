# `make demo` and `make test` do everything, on a machine with only make and Python 3.11.
# Set VENV to install elsewhere, PYTHON to choose an interpreter, WORKERS for how many test at once.

VENV ?= .venv
# One more than the cores of a small machine: tests wait for browsers and for processes.
WORKERS ?= 3
PYTHON ?= $(shell for p in python3.11 python3 python3.12 python3.13; do \
	$$p -c 'import sys; sys.exit(sys.version_info < (3, 11))' 2>/dev/null && echo $$p && break; done)

# The fluid is a C function: where there is no compiler, pip brings one.
EXTRAS := dev$(shell command -v cc >/dev/null || command -v gcc >/dev/null || command -v clang >/dev/null || echo ,compiler)

bin := $(VENV)/bin
# Bytecode is kept, whatever the environment says: tests start hundreds of processes.
export PYTHONDONTWRITEBYTECODE :=
# The stamp carries the checksum of pyproject.toml, so that what is installed is never installed again.
stamp := $(VENV)/.installed-$(shell cksum < pyproject.toml | cut -d ' ' -f 1)

# The viewer is tested in a real browser.
browsers := chromium chromium-browser google-chrome google-chrome-stable
debs := chromium libgl1-mesa-dri libegl1 libgles2

# What is printed is sliced by the real slicer.
slicers := prusa-slicer PrusaSlicer

.PHONY: help demo test collect install lint types arrows browser slicer fuzz mutants figures results site clean

help: ## Show this list
	@sed -n 's/^\([a-z]*\):.*## \(.*\)/  make \1|\2/p' Makefile | awk -F '|' '{printf "%-16s%s\n", $$1, $$2}'

demo: $(stamp) ## Conceal a piece of physics, diagnose it, and compare the finding with the truth
	@$(bin)/python -m experiments.demo

test: browser slicer $(stamp) ## Check style, types and imports, then run every test
	@$(MAKE) --no-print-directory --jobs 2 lint types arrows collect
	$(bin)/python -m pytest -n $(WORKERS) --dist worksteal

# The workers would each compile the tests, at the same time.
collect: $(stamp)
	-@$(bin)/python -m pytest --collect-only -qq >/dev/null 2>&1

lint: $(stamp) ## Check style
	$(bin)/ruff check .
	$(bin)/ruff format --check .

types: $(stamp) ## Check types
	$(bin)/mypy

arrows: $(stamp) ## Check that imports point the right way
	$(bin)/lint-imports --no-logo

browser: ## See that there is a browser to test the viewer in; as root on Debian, install one
	@for each in $(browsers); do command -v $$each >/dev/null && exit 0; done; \
	if [ "$$(id -u)" = 0 ] && command -v apt-get >/dev/null; then \
		echo "Installing $(debs), which the tests of the viewer look with ..."; \
		apt-get update -qq && DEBIAN_FRONTEND=noninteractive apt-get install -y -qq --no-install-recommends $(debs) >/dev/null && exit 0; \
	fi; \
	echo "There is no browser, so the viewer is not tested in one. On Debian: sudo apt-get install $(debs)" >&2

slicer: ## See that there is a slicer to test prints with; as root on Debian, install one
	@for each in $(slicers); do command -v $$each >/dev/null && exit 0; done; \
	if [ "$$(id -u)" = 0 ] && command -v apt-get >/dev/null; then \
		echo "Installing prusa-slicer, which the tests of prints slice with ..."; \
		apt-get update -qq && DEBIAN_FRONTEND=noninteractive apt-get install -y -qq --no-install-recommends prusa-slicer >/dev/null && exit 0; \
	fi; \
	echo "There is no slicer, so what is printed is only estimated and no G-code is tested. On Debian: sudo apt-get install prusa-slicer" >&2

fuzz: $(stamp) ## Feed every reader with spoiled files for an hour; what crashes is kept in out/fuzz
	$(bin)/python -m experiments.fuzz_readers all --seconds 3600 --out out/fuzz

figures: $(stamp) ## Write the tables of figures in README.md and experiments/README.md from the result files
	$(bin)/python -m experiments.figures

site: $(stamp) ## Build the documentation as a site, in out/site
	@NO_MKDOCS_2_WARNING=1 $(bin)/python -m mkdocs build --quiet

results: $(stamp) ## Print the commands of results that are missing or whose code has changed
	@$(bin)/python -m experiments.figures --commands

mutants: $(stamp) ## Plant small bugs one at a time, and count those that the tests notice; ARGS="--area gate" tries one area
	$(bin)/python -m experiments.mutants --fresh $(ARGS)

install: $(stamp) ## Set up what is missing, and no more

clean: ## Remove caches and results; the installation stays
	rm -rf out build dist *.egg-info .mypy_cache .ruff_cache .pytest_cache .import_linter_cache
	find align docs experiments morph print tests -name __pycache__ -type d -prune -exec rm -rf {} +

$(stamp): | $(bin)/pip
	@echo "Installing morph and its dependencies into $(VENV); the first time takes some minutes ..."
	@$(bin)/python -m pip install --disable-pip-version-check -qq -e '.[$(EXTRAS)]'
	@rm -f $(VENV)/.installed-*
	@touch $@
	@echo "Installed."

$(bin)/pip:
	@test -n "$(PYTHON)" || { echo "No Python 3.11 or newer was found. Install one, or name it: make PYTHON=/path/to/python3.11" >&2; exit 1; }
	@$(PYTHON) -c 'import ensurepip, venv' 2>/dev/null || { \
		if [ "$$(id -u)" = 0 ] && command -v apt-get >/dev/null; then \
			echo "Installing python3-venv, which $(PYTHON) lacks ..."; \
			apt-get update -qq && DEBIAN_FRONTEND=noninteractive apt-get install -y -qq python3-venv >/dev/null; \
		fi; \
		$(PYTHON) -c 'import ensurepip, venv' || { \
			echo "$(PYTHON) cannot make a virtual environment. On Debian or Ubuntu: sudo apt-get install python3-venv" >&2; exit 1; }; }
	@echo "Making a virtual environment in $(VENV) ..."
	@$(PYTHON) -m venv $(VENV)
