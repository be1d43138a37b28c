# The same targets for everyone: a newcomer, a developer, CI. Nothing is installed outside .venv, except, for root on
# Debian, the system libraries of Blender's module (requirements/system.sh).
.DEFAULT_GOAL := help
SHELL := /bin/sh

# bpy 4.5 exists for Python 3.11 only, so 3.11 is taken where there is one
PYTHON ?= $(shell command -v python3.11 || command -v python3)
VENV := .venv
PY := $(VENV)/bin/python
PIP := $(PY) -m pip install --quiet --disable-pip-version-check

.PHONY: help demo examples bench test test-fast test-shuffled lint extension check-extension shots clean

help:  ## Show this list
	@awk -F ':.*## ' '/^[a-z-]+:.*## / { printf "  make %-15s %s\n", $$1, $$2 }' $(MAKEFILE_LIST)

demo: $(VENV)/.demo  ## Compress, measure and render a sculpt (or MESH=path) into out/demo
	$(PY) -m npm_blender demo $(if $(MESH),"$(MESH)")

examples: $(VENV)/.test  ## Run every stage of the method on one small mesh, and make a page of it: out/examples/index.html
	$(PY) -m examples.gallery

bench: $(VENV)/.bench  ## Compare with other codecs on CORPUS=path, or on meshes that Blender makes; QUICK=1: 6 meshes
	$(PY) -m benchmarks.compare $(if $(CORPUS),"$(CORPUS)") $(if $(QUICK),--quick) $(BENCH)

test: $(VENV)/.test  ## Run the tests (or those of TESTS=path)
	$(PY) -m pytest $(TESTS)

test-fast: $(VENV)/.test  ## Run the tests that are quick and need no Blender, on two cores: a minute once all is compiled
	$(PY) -m pytest -m "not slow and not blender" --ignore=tests/addon -n 2 --dist loadfile $(TESTS)

test-shuffled: $(VENV)/.test  ## Run the tests in an order drawn by SEED: none may lean on another
	$(PY) -m pytest --random-order-bucket=module --random-order-seed=$(or $(SEED),1) $(TESTS)

lint: $(VENV)/.test  ## Check the style, and the types of the core
	$(PY) -m ruff check
	$(PY) -m mypy

extension: $(VENV)/.demo  ## Build the extension's zips into dist (DEBIAN=1: for Debian's Blenders; BLENDER=path builds)
	$(PY) -m extension.build $(if $(DEBIAN),--debian) $(if $(BLENDER),--blender "$(BLENDER)")

check-extension: $(PY)  ## Install the zip in a Blender of factory settings (BLENDER=path) and use it
	$(if $(BLENDER),BLENDER="$(BLENDER)") $(PY) -m extension.check_install

shots: $(VENV)/.bench  ## Take the manual's pictures in a Blender with a window (BLENDER=path)
	$(PY) docs/shots/make.py $(BLENDER)

clean:  ## Remove what the other targets made
	rm -rf $(VENV) out build dist

# A stamp per set of requirements: done once, and again when the set changes.
$(VENV)/.demo: requirements/run.txt requirements/demo.txt requirements/system.sh | $(PY)
	@echo "Installing requirements/demo.txt into $(VENV) (once; some minutes)"
	$(PIP) -r requirements/demo.txt
	sh requirements/system.sh $(PY)
	@touch $@

$(VENV)/.test: requirements/test.txt requirements/train.txt $(VENV)/.demo
	@echo "Installing requirements/test.txt into $(VENV) (once)"
	$(PIP) -r requirements/test.txt
	@touch $@

$(VENV)/.bench: requirements/bench.txt $(VENV)/.test
	@echo "Installing requirements/bench.txt into $(VENV) (once)"
	$(PIP) -r requirements/bench.txt
	@touch $@

$(PY):
	@test -n "$(PYTHON)" || { echo "Expected Python 3.11, found none; on Debian run: apt-get install python3 python3-venv" >&2; exit 1; }
	@"$(PYTHON)" -c 'import sys; sys.exit(sys.version_info[:2] != (3, 11))' || { echo \
	  "Expected Python 3.11 (Blender 4.5's), found $$("$(PYTHON)" --version 2>&1); install it, or name it: make PYTHON=path" >&2; exit 1; }
	@"$(PYTHON)" -m venv $(VENV) || { rm -rf $(VENV); echo \
	  "Expected Python's venv module to work, found the error above; on Debian run: apt-get install python3-venv" >&2; exit 1; }
