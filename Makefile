# `make demo` and `make test` set everything up themselves, from Python 3.11 or newer and nothing else.

SHELL := bash
PYTHON ?= python3
BIN := .venv/bin
READY := .venv/.ready
export OPENBLAS_NUM_THREADS = 1
export OMP_NUM_THREADS = 1
export MKL_NUM_THREADS = 1

.PHONY: demo test test-long lint package docs pages lock clean

demo: $(READY) ## the demo study, from rendered footage to results/demo/report.html
	@$(BIN)/bluekoi run demo

test: $(READY) ## the tests
	$(BIN)/pytest -n 2 --dist loadfile

test-long: $(READY) ## tests that run for minutes: the demo held against its truth, and more
	$(BIN)/pytest -m long -o addopts="--strict-markers" --timeout 3600

lint: $(READY) ## linters, import contract, types, workflow
	$(BIN)/ruff check .
	$(BIN)/ruff format --check .
	$(BIN)/lint-imports
	$(BIN)/mypy
	$(BIN)/snakemake --lint

package: $(READY) ## sdist and wheel in dist/, checked, installed into an empty environment and tried
	$(BIN)/python .ci/package.py --install

docs: $(READY) ## the documentation, docs/_build/html/index.html; a broken link is an error
	@rm -rf docs/_build/html
	$(BIN)/sphinx-build -q -W --keep-going -b html -d docs/_build/doctrees docs docs/_build/html
	$(BIN)/python docs/check_site.py docs/_build/html

pages: $(READY) ## the pages of docs/ that are generated from the code
	for name in study_keys effects commands api; do $(BIN)/python docs/$${name}_page.py; done

lock: ## requirements.lock from pyproject.toml (needs uv)
	uv pip compile pyproject.toml --extra dev --universal --python-version 3.11 \
		--generate-hashes --no-header --no-emit-index-url -o requirements.lock

$(READY): requirements.lock pyproject.toml setup.py
	@$(PYTHON) -c 'import sys; sys.exit(sys.version_info < (3, 11))' 2>/dev/null || { \
		echo "Python 3.11 or newer is needed as '$(PYTHON)'; another one: make PYTHON=python3.12 ..." >&2; exit 1; }
	@$(PYTHON) -c 'import ensurepip, venv' 2>/dev/null || { \
		echo "Python's venv module is missing; on Debian and Ubuntu: apt-get install python3-venv" >&2; exit 1; }
	@echo "Setting up .venv, once (about a minute) ..."
	@$(PYTHON) -m venv .venv
	@$(BIN)/python -m pip install --quiet --disable-pip-version-check --require-hashes -r requirements.lock
	@$(BIN)/python -m pip install --quiet --disable-pip-version-check --no-deps --no-build-isolation -e .
	@touch $@

clean: ## the environment and everything rendered or computed
	rm -rf .venv results studies .snakemake docs/_build dist
