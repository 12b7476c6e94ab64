# Every target does its own set-up and remembers it: a second call starts at once.
#
#   make run         serve the site on http://127.0.0.1:8000 (HOST and PORT change that)
#   make test        lint, then the tests of the model, the site, the front end and the browser
#   make lint        style, types and the rules of who may import whom
#   make format      put the Python files into the one style
#   make train       the shipped estimators, from the shipped population (minutes)
#   make population  the open population from nothing, through Anny and PyTorch (up to an hour)
#   make stance      people drawn anew, and what one stance for all bodies takes away
#   make report      the population beside the survey, the paper's study repeated, and the
#                    estimators' errors, as pages of docs/
#                    (ARGS="--survey-rows FOLDER": their errors on real people too)
#   make guide       docs/measurements.md: every measurement, its picture and its spread; and the
#                    pictures of the wizard, static/guide/ (minutes)
#   make words       the texts of the pages, gathered for the translations, which it compiles
#   make bench       how long measuring takes, beside a peer's way, in one run (ARGS="--rounds 9");
#                    then the real server for half a minute, beside a plain page
#   make lighthouse  Lighthouse's scores of the wizard and the avatar's page, on a slow telephone
#   make axe         what axe finds wrong on any page, in both languages, in the light and in the dark
#   make frames      what each picture of the body in 3D costs, at rest, dragged and turning
#   make fuzz        50,000 generated requests, none of which may be answered 5xx
#   make faults      a real server, broken in the ways in which servers break
#   make audit       newer versions and known weaknesses of the locked packages, where the registries
#                    tell of them
#   make api         docs/api.md, from the site's OpenAPI document
#   make licences    docs/licences.md, from the metadata of what is installed
#   make lock        the lock files, from pyproject.toml
#   make clean       remove environments, packages and built files (not the secret in instance/,
#                    nor the fitted bodies in build/)
#
# NO_INSTALL=1 keeps them from installing system packages: they name the package instead.

HOST ?= 127.0.0.1
PORT ?= 8000

VENV := .venv
POPULATION_VENV := .venv-population
LOCK_VENV := .venv-lock
AUDIT_VENV := .venv-audit
FUZZ_VENV := .venv-fuzz
BIN := $(VENV)/bin
PIP_INSTALL := -m pip install -qq --disable-pip-version-check --no-deps

SITE := $(VENV)/site.stamp
DEV := $(VENV)/dev.stamp
POPULATION := $(POPULATION_VENV)/population.stamp
NODE_MODULES := node_modules/.installed
FRONT_END := static/build/.built

PYTHON_CODE := model webapp bench tests scripts
SCRIPTS := $(shell find static -path static/build -prune -o -name '*.js' -print 2>/dev/null) \
	$(wildcard scripts/*.mjs)

export PLAYWRIGHT_SKIP_BROWSER_DOWNLOAD := 1
export NPM_CONFIG_UPDATE_NOTIFIER := false

.PHONY: help run test lint format train population stance report guide words bench lighthouse axe frames fuzz faults audit api licences lock clean
.DELETE_ON_ERROR:

help:
	@sed -n '/^#/!q; s/^# \{0,1\}//p' Makefile

# ---------------------------------------------------------------- what people call

run: $(SITE) $(FRONT_END) instance/secret_key
	@scripts/require.sh osmesa || echo "warning: serving without the two pictures"
	@echo "Serving http://$(HOST):$(PORT)/ (stop with Ctrl-C)"
	@PATH="$(CURDIR)/$(BIN):$$PATH" HOST="$(HOST)" PORT="$(PORT)" \
		FITTING_ROOM_LOCAL="$${FITTING_ROOM_LOCAL:-1}" \
		SECRET_KEY="$${SECRET_KEY:-$$(cat instance/secret_key)}" \
		sh -c "$$(sed -n 's/^web: /exec /p' Procfile)"

# What waits for the network and what keeps one core busy goes side by side.
SIDE_BY_SIDE = $(MAKE) --no-print-directory --jobs 2

# What the machine must provide comes first, one after the other: packages are installed alone.
test: $(VENV)/bin/python
	@scripts/require.sh node
	@scripts/require.sh osmesa
	@scripts/require.sh chromium
	@scripts/require.sh redis || echo "warning: limits that servers share will not be tested"
	@scripts/require.sh nginx || echo "warning: two servers behind nginx will not be tested"
	@$(SIDE_BY_SIDE) $(DEV) $(FRONT_END)
	@$(SIDE_BY_SIDE) types others
	@echo "Testing the model and the site"
	@$(BIN)/python -m pytest -q -rs -n auto --dist loadfile --no-loadscope-reorder
	@echo "Testing in the browser"
	@PATH="$(CURDIR)/$(BIN):$$PATH" npm run --silent test:browser

lint: $(DEV)
	@$(SIDE_BY_SIDE) types rules

.PHONY: types rules others
types:
	@echo "Checking types"
	@$(BIN)/mypy

rules:
	@echo "Checking style and imports"
	@$(BIN)/ruff check --quiet
	@$(BIN)/ruff format --quiet --check || { echo "run: make format"; exit 1; }
	@$(BIN)/lint-imports --no-logo

others: rules
	@echo "Testing the front end"
	@npm run --silent test:unit

format: $(DEV)
	@$(BIN)/ruff check --fix-only --quiet
	@$(BIN)/ruff format

train: $(DEV)
	@$(BIN)/python -m model.training train $(ARGS)

report: $(DEV)
	@scripts/require.sh osmesa
	@$(BIN)/python -m model.training report $(ARGS)

guide: $(DEV)
	@scripts/require.sh osmesa
	@$(BIN)/python -m model.training measurements
	@$(BIN)/python -m model.training guide

words: $(SITE)
	@$(BIN)/python scripts/words.py

bench: $(SITE)
	@$(BIN)/python -m bench $(ARGS)

lighthouse: $(SITE) $(FRONT_END)
	@scripts/require.sh chromium
	@npm run --silent lighthouse

axe: $(SITE) $(FRONT_END)
	@scripts/require.sh chromium
	@npm run --silent axe

frames: $(SITE) $(FRONT_END)
	@scripts/require.sh chromium
	@npm run --silent frames

# Schemathesis stays apart: it has an environment of its own, which sees all of the other one.
fuzz: $(DEV)
	@scripts/require.sh venv $(FUZZ_VENV)
	@echo "$(CURDIR)/$$(echo $(VENV)/lib/python3*/site-packages)" >"$$(echo $(FUZZ_VENV)/lib/python3*)/site-packages/site.pth"
	@$(FUZZ_VENV)/bin/python -m pip install -qq --disable-pip-version-check schemathesis \
		|| echo "warning: fuzzing without Schemathesis, which could not be installed"
	@$(FUZZ_VENV)/bin/python scripts/fuzz.py $(ARGS)

faults: $(SITE)
	@scripts/require.sh nginx
	@scripts/require.sh faketime || echo "warning: the clock will not be tried"
	@$(BIN)/python scripts/faults.py $(ARGS)

population: $(POPULATION)
	@scripts/require.sh osmesa
	@$(POPULATION_VENV)/bin/python -m model.training population $(ARGS)

stance: $(POPULATION)
	@$(POPULATION_VENV)/bin/python -m model.training stance $(ARGS)

# A package that cannot be looked up is a failure too: silence is no answer.
audit: $(SITE) $(NODE_MODULES)
	@echo "Newer than what is locked:"
	@$(BIN)/python -m pip list --disable-pip-version-check --outdated --exclude pip --exclude setuptools
	@npm outdated || true
	@scripts/require.sh venv $(AUDIT_VENV)
	@$(AUDIT_VENV)/bin/python -m pip install -qq --disable-pip-version-check pip-audit
	@$(AUDIT_VENV)/bin/pip-audit --strict --require-hashes --disable-pip -r requirements.txt
	@npm audit --omit=dev

api: $(SITE)
	@$(BIN)/python scripts/api_page.py --write

licences: $(DEV) $(NODE_MODULES)
	@$(BIN)/python scripts/licences.py --write

clean:
	@echo "Removing environments, packages, built files and caches"
	@rm -rf $(VENV) $(POPULATION_VENV) $(LOCK_VENV) $(AUDIT_VENV) $(FUZZ_VENV) node_modules static/build \
		.hypothesis .import_linter_cache .mypy_cache .pytest_cache .ruff_cache \
		test-results playwright-report
	@find $(PYTHON_CODE) -name __pycache__ -prune -exec rm -rf {} + 2>/dev/null || true

# ---------------------------------------------------------------- set-up, remembered by stamps

$(VENV)/bin/python:
	@scripts/require.sh venv $(VENV)

$(SITE): requirements.txt | $(VENV)/bin/python
	@echo "Installing the Python packages of requirements.txt"
	@$(BIN)/python $(PIP_INSTALL) -r requirements.txt
	@touch $@

$(DEV): requirements-dev.txt | $(VENV)/bin/python
	@echo "Installing the Python packages of requirements-dev.txt (about a minute)"
	@$(BIN)/python $(PIP_INSTALL) -r requirements-dev.txt
	@touch $(SITE) $@

$(POPULATION_VENV)/bin/python:
	@scripts/require.sh venv $(POPULATION_VENV)

# A build of torch for a graphics card brings a runtime of its own, which the lock file leaves
# out: the second step lets it ask for that.
$(POPULATION): requirements-population.txt | $(POPULATION_VENV)/bin/python
	@echo "Installing Anny and PyTorch (some minutes)"
	@$(POPULATION_VENV)/bin/python $(PIP_INSTALL) -r requirements-population.txt
	@$(POPULATION_VENV)/bin/python -m pip install -qq --disable-pip-version-check \
		"$$(grep '^torch==' requirements-population.txt)"
	@touch $@

$(NODE_MODULES): package.json package-lock.json
	@scripts/require.sh node
	@echo "Installing the npm packages of package-lock.json"
	@npm ci --loglevel=error --no-audit --no-fund
	@touch $@

$(FRONT_END): $(NODE_MODULES) $(SCRIPTS)
	@echo "Building the front end"
	@npm run --silent build
	@mkdir -p $(@D)
	@touch $@

# Sessions are signed: a key kept here survives a restart. A deployed site sets SECRET_KEY itself.
instance/secret_key: | $(VENV)/bin/python
	@mkdir -p $(@D)
	@umask 077 && $(BIN)/python -c 'import secrets; print(secrets.token_hex(32))' >$@

# ---------------------------------------------------------------- lock files

UV_COMPILE = $(LOCK_VENV)/bin/uv pip compile pyproject.toml --quiet --universal \
	--fork-strategy fewest --custom-compile-command "make lock" $(ARGS)

# All three agree with one another, and none names the host that a package came from. Torch has
# one build for each kind of machine, so the population's file holds no hashes.
lock:
	@scripts/require.sh venv $(LOCK_VENV)
	@$(LOCK_VENV)/bin/python -m pip install -qq --disable-pip-version-check uv
	@$(UV_COMPILE) --generate-hashes -o requirements.txt
	@$(UV_COMPILE) --generate-hashes --group dev -c requirements.txt -o requirements-dev.txt
	@$(UV_COMPILE) --group population -c requirements.txt -o requirements-population.txt
