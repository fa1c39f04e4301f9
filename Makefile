# `make demo` and `make test` each work as the only command typed in a fresh clone; `make help` lists the rest.

SHELL := /bin/bash
.SHELLFLAGS := -eu -o pipefail -c
.ONESHELL:
.SUFFIXES:
.DEFAULT_GOAL := help

VENV := .venv
BIN := $(VENV)/bin
PIP := $(BIN)/python -m pip --disable-pip-version-check
PYTEST := $(BIN)/python -m pytest --numprocesses auto --maxprocesses 4 --dist loadgroup --no-loadscope-reorder
# Empty is unset: otherwise each program that the tests start would compile all its modules anew.
export PYTHONDONTWRITEBYTECODE :=
INSTALL := $(PIP) install --quiet
# Nothing that is built needs more than setuptools, which is of the core; an isolated build would download what has no hash.
# The files are complete; pip does not accept the hash of coverage for coverage[toml], which it would look up itself.
HASHED := $(INSTALL) --require-hashes --no-deps --no-build-isolation --requirement
# pip checks no hash of a folder.
EDITABLE := $(INSTALL) --no-deps --no-build-isolation --editable .

SYSTEM_PACKAGES := xvfb xauth libgl1 libglu1-mesa libfontconfig1 libportaudio2 pulseaudio pulseaudio-utils libasound2-plugins
PLATFORMS := x86_64-manylinux_2_36 aarch64-apple-darwin x86_64-apple-darwin x86_64-pc-windows-msvc
PYTHONS := 3.11 3.12
# Ground and ink of the dark figure; blue is too dark on it, and the palette's sky is not.
NIGHT := \#0d1117
MOON := \#e6edf3
PINNED = $(BIN)/uv pip compile pyproject.toml --quiet --universal --python-version 3.11 --no-annotate --no-header \
    --no-emit-index-url --no-emit-find-links
RELEASE_TOOLS := build twine reuse cyclonedx-bom pip-audit uv

# A shell function: install the named Debian packages that are missing, where the user may; else say which ones.
define debian
debian() {
    local missing="" package
    for package in "$$@"; do
        [ "$$(dpkg-query -W -f '$${db:Status-Status}' $$package 2>/dev/null || true)" = installed ] || missing="$$missing $$package"
    done
    [ -n "$$missing" ] || return 0
    local may="env DEBIAN_FRONTEND=noninteractive"
    [ "$$(id -u)" = 0 ] || may="sudo -n $$may"
    if command -v apt-get >/dev/null && $$may true 2>/dev/null; then
        echo "Installing the system packages:$$missing"
        $$may apt-get -qq update
        $$may apt-get -qq -o Dpkg::Use-Pty=0 install -y --no-install-recommends $$missing >/dev/null
    else
        echo "make: these system packages are missing; ask an administrator for: apt-get install --no-install-recommends$$missing" >&2
        return 1
    fi
}
endef

.PHONY: help demo test soak static check bench docs gallery notebooks figure release pages reproduced validated keys stability constraints hashes platforms clean system

help: ## what can be made
	@sed -nE 's/^([a-z]+):.*## (.*)/make \1\t\2/p' Makefile | expand -t 20

demo: $(VENV)/.core ## simulate a study, analyse it and write the report to demo/
	@$(BIN)/tactometry demo --out demo
	@echo "next: . $(BIN)/activate    # this shell then finds the command tactometry"

test: system $(VENV)/.test ## every behaviour, law and device once, on all cores
	@$(PYTEST) -m 'not slow' --hypothesis-profile once $(ARGS)

soak: system $(VENV)/.test ## all tests at full size: hours
	@TACTOMETRY_SOAK=1 $(BIN)/python -m pytest --timeout 14400 $(ARGS)

static: $(VENV)/.test ## format, lint, strict types, import contracts
	@$(BIN)/ruff format --check .
	$(BIN)/ruff check .
	$(BIN)/mypy
	$(BIN)/lint-imports --no-logo

check: static system $(VENV)/.test ## the static checks, then all tests with branch coverage: what CI runs
	@$(PYTEST) --cov $(ARGS)

bench: system $(VENV)/.test ## every benchmark, and benchmarks/README.md; ARGS="watch traces" renews two
	@$(BIN)/python benchmarks/table.py $(ARGS)

docs: $(VENV)/.test ## build the site into docs/_build/html, without a network; a warning or a dead link fails
	@$(BIN)/python -m sphinx --quiet --fail-on-warning --keep-going --nitpicky --fresh-env --write-all docs docs/_build/html $(ARGS)
	echo "The site is docs/_build/html/index.html"

figure: $(VENV)/.core ## draw the figure of the README anew, light and dark
	@$(BIN)/tactometry demo --out demo >/dev/null
	$(BIN)/tactometry analyse demo --figures demo/figures >/dev/null
	cp demo/figures/threshold.svg docs/readme/light.svg
	sed -e 's/#ffffff/$(NIGHT)/; s/#000000/$(MOON)/g; s/#0072b2/#56b4e9/g; 1s/<svg /<svg fill="$(MOON)" /' \
	    docs/readme/light.svg > docs/readme/dark.svg

release: $(VENV)/release ## build and check wheel and sdist into dist/, with a list of materials; publishes nothing
	@$(VENV)/release/bin/python .ci/release.py $(ARGS)

gallery: $(VENV)/.test ## run the pages of docs/gallery, and keep the figures that they show
	@$(BIN)/python tests/support/gallery.py >/dev/null

notebooks: $(VENV)/.test ## run docs/notebooks, and write into them what they show
	@$(BIN)/python tests/support/notebooks.py

pages: $(VENV)/.test ## write docs/explanation/cost.md (accuracy), docs/explanation/reproduced.md (the thesis) and docs/explanation/stability.md (hard cases) anew
	@$(BIN)/tactometry cost all --page docs/explanation/cost.md >/dev/null
	$(MAKE) --no-print-directory reproduced stability

reproduced: $(VENV)/.core ## write docs/explanation/reproduced.md: what of the thesis comes out
	@$(BIN)/tactometry reproduce all --page docs/explanation/reproduced.md >/dev/null

validated: $(VENV)/.core ## write docs/explanation/validated.md anew: our methods, put to known truths; half an hour of two cores
	@$(BIN)/tactometry validate-method --out docs/.validated --rounds 20 --jobs 2 --page docs/explanation/validated.md >/dev/null
	@rm -rf docs/.validated

keys: $(VENV)/.core ## write the tables of keys and the page of commands in docs/reference anew
	@$(BIN)/python -m tactometry.experiments.reference.pages
	$(BIN)/python -m tactometry.cli.reference

stability: system $(VENV)/.test ## write docs/explanation/stability.md from the hard cases of the tests
	@$(BIN)/python -m pytest -q --stability

constraints: $(VENV)/.python ## write constraints.txt and requirements/ anew: the newest versions that pyproject.toml admits
	@$(PIP) install --quiet uv
	pinned=$$(mktemp)
	$(PINNED) --upgrade --all-extras --output-file $$pinned
	{ echo "# Exact versions for Python 3.11 and 3.12 on every platform. Written by: make constraints"; \
	    grep -v '^pyobjc-framework-' $$pinned; } > constraints.txt
	rm $$pinned
	$(MAKE) --no-print-directory hashes

hashes: $(VENV)/.python ## write requirements/ anew: the versions of constraints.txt with the hashes of their files
	@$(PIP) install --quiet uv
	for set in core all; do
	    extras=""
	    [ $$set = core ] || extras=--all-extras
	    echo setuptools | $(PINNED) - $$extras --constraint constraints.txt --generate-hashes --output-file requirements/$$set.txt >/dev/null
	    sed -i '1i # Versions with hashes, for pip install --require-hashes. Written by: make hashes' requirements/$$set.txt
	done

platforms: $(VENV)/.python ## resolve every platform with wheels only (esprima has none, and is pure Python)
	@$(PIP) install --quiet uv
	for platform in $(PLATFORMS); do for python in $(PYTHONS); do
	    $(BIN)/uv pip compile pyproject.toml --quiet --python-platform $$platform --python-version $$python \
	        --all-extras --constraint constraints.txt --only-binary :all: --no-binary esprima --output-file /dev/null >/dev/null \
	        && echo "$$platform, Python $$python: resolved" || { echo "$$platform, Python $$python: not resolved" >&2; exit 1; }
	done; done

clean: ## remove what was made, but not .venv
	@rm -rf build dist demo docs/_build htmlcov *.egg-info .coverage .coverage.* .pytest_cache .mypy_cache .ruff_cache \
	    .hypothesis .import_linter_cache
	find . -name __pycache__ -not -path './$(VENV)/*' -prune -exec rm -rf {} +

system:
	@$(debian)
	debian $(SYSTEM_PACKAGES)

# The first Python that really runs (a pyenv shim of an inactive version does not) and is 3.11 or 3.12.
$(VENV)/.python:
	@$(debian)
	for python in $(or $(PYTHON),python3.11 python3.12 python3 /usr/bin/python3) none; do
	    $$python -c 'import sys; sys.exit(sys.version_info[:2] not in ((3, 11), (3, 12)))' 2>/dev/null && break
	done
	[ $$python != none ] || { echo "make: found no Python 3.11 or 3.12 that runs$(PYTHON:%= (%)); name one: make PYTHON=/path/to/python" >&2; exit 1; }
	if ! $$python -c 'import ensurepip, venv' 2>/dev/null; then
	    debian $$($$python -c 'import sys; print("python3.%d-venv" % sys.version_info[1])')
	fi
	$$python -m venv $(VENV)
	touch $@

$(VENV)/.core: $(VENV)/.python pyproject.toml setup.py requirements/core.txt
	@echo "Installing Tactometry with the packages of its core (180 MB to download) ..."
	$(HASHED) requirements/core.txt
	$(EDITABLE)
	touch $@

$(VENV)/.test: $(VENV)/.python pyproject.toml setup.py requirements/core.txt requirements/all.txt
	@echo "Installing Tactometry with all that its tests need, PsychoPy too (695 MB to download) ..."
	$(HASHED) requirements/core.txt
	$(HASHED) requirements/all.txt
	$(EDITABLE)
	touch $(VENV)/.core $@

# An environment of their own: what they need is none of ours
$(VENV)/release: $(VENV)/.python
	@$(BIN)/python -m venv $@
	$@/bin/python -m pip --disable-pip-version-check install --quiet $(RELEASE_TOOLS)
