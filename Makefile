# Everything runs in .venv, made on first use. Needed: make and Python 3.11 or newer.
#   make demo       form a woven blank over a double dome on the CPU and say where to look
#   make install    install it with all that tests and documentation need
#   make test       run the test suite on the CPU
#   make test-fast  run it without the slow tests, under a minute once the kernels are compiled
#   make verify     run the verification studies and rebuild docs/verification.md (about 20 minutes)
#   make hour       form two tools from their surfaces to a structural model, as a newcomer would (under 10 minutes)
#   make render     install Blender as a Python module in .venv-render (1 GB, Python 3.11), and render the film with it
#   make readers    install pyNastran and ansys-dyna-core in .venv-readers (0.7 GB), and read exported decks with them
#   make soak       kill, damage and exhaust it for hours; SOAK="--part kills --count 200" takes one part (scripts/soaking/soak.py)
#   make site       build the documentation as a site, without a network: build/site/html/index.html
#   make gallery    make the pictures of the documentation anew (minutes), and notebooks likewise: make notebooks
#   make audit      look at bounds and licences of all dependencies, as installed
#   make release    build source archive and wheel twice from the last commit; the bytes have to agree
#   make lint       check style, formatting and types; make style and make types do one of them

VENV := .venv
PYTHON_IN_VENV := $(VENV)/bin/python
# Two workers suit two cores; more would mostly compile the same kernels once more each.
WORKERS ?= 2

# The hundred processes that the tests start read compiled modules where the environment asks that none are written.
test test-fast: export PYTHONDONTWRITEBYTECODE =

.PHONY: demo install test test-fast verify hour render readers soak site gallery notebooks audit release lint style types clean

install: $(VENV)/.installed-all

demo: $(VENV)/.installed
	$(PYTHON_IN_VENV) scripts/double_dome.py --overwrite

test: $(VENV)/.installed-test
	$(PYTHON_IN_VENV) -m pytest --numprocesses $(WORKERS) --dist loadfile --no-loadscope-reorder

test-fast: $(VENV)/.installed-test
	$(PYTHON_IN_VENV) -m pytest --numprocesses $(WORKERS) --dist worksteal -m "not verification and not slow"

verify: $(VENV)/.installed-test
	$(PYTHON_IN_VENV) scripts/verification.py --workers $(WORKERS)

hour: $(VENV)/.installed-test
	$(PYTHON_IN_VENV) -m pytest tests/validation/test_own_part.py -m hour -s

# Blender wants an older NumPy than the tests, hence an environment of its own.
render: $(VENV)/.installed-test .venv-render/.installed
	$(PYTHON_IN_VENV) -m pytest tests/unit/output/film

.venv-render/.installed: $(VENV)/.installed
	@$(PYTHON_IN_VENV) -m venv .venv-render
	@.venv-render/bin/python -m pip install --quiet --disable-pip-version-check "bpy>=4.2"
	@touch $@

readers: $(VENV)/.installed-test .venv-readers/.installed
	$(PYTHON_IN_VENV) -m pytest tests/unit/output/export/test_readers.py

.venv-readers/.installed: $(VENV)/.installed
	@$(PYTHON_IN_VENV) -m venv .venv-readers
	@.venv-readers/bin/python -m pip install --quiet --disable-pip-version-check "pyNastran>=1.4" "ansys-dyna-core>=0.10"
	@touch $@

soak: $(VENV)/.installed-test
	$(PYTHON_IN_VENV) scripts/soaking/soak.py $(SOAK)

site: $(VENV)/.installed-docs
	$(PYTHON_IN_VENV) scripts/documentation/make_site.py

gallery: $(VENV)/.installed
	$(PYTHON_IN_VENV) scripts/documentation/make_gallery.py

notebooks: $(VENV)/.installed-docs
	$(PYTHON_IN_VENV) scripts/documentation/make_notebooks.py

audit: $(VENV)/.installed-test
	$(PYTHON_IN_VENV) scripts/releasing/audit.py

release: $(VENV)/.installed-test
	$(PYTHON_IN_VENV) scripts/releasing/release.py

lint: style types

style: $(VENV)/.installed-test
	$(PYTHON_IN_VENV) -m ruff check
	$(PYTHON_IN_VENV) -m ruff format --check

types: $(VENV)/.installed-test
	$(PYTHON_IN_VENV) scripts/check_types.py

clean:
	rm -rf $(VENV) .venv-render .venv-readers build dist *.egg-info

# PYTHON=/path/to/python names an interpreter; without it the first that is new enough is taken.
$(VENV)/.made:
	@for python in $(PYTHON) python3 python3.14 python3.13 python3.12 python3.11; do \
		if $$python -c 'import sys; sys.exit(sys.version_info < (3, 11))' 2>/dev/null; then \
			echo "Installing weavesim in $(VENV) with $$($$python --version) ..."; \
			exec $$python -m venv $(VENV); \
		fi; \
	done; \
	echo "weavesim needs Python 3.11 or newer: install it, or name one with PYTHON=/path/to/python." >&2; exit 2
	@touch $@

$(VENV)/.installed: pyproject.toml | $(VENV)/.made
	@$(PYTHON_IN_VENV) -m pip install --quiet --disable-pip-version-check --editable .
	@touch $@

$(VENV)/.installed-test: $(VENV)/.installed
	@$(PYTHON_IN_VENV) -m pip install --quiet --disable-pip-version-check --editable ".[test]"
	@touch $@

$(VENV)/.installed-docs: $(VENV)/.installed
	@$(PYTHON_IN_VENV) -m pip install --quiet --disable-pip-version-check --editable ".[docs]"
	@touch $@

# All of these at once: one resolution, one build. Modules are compiled when they are imported, which few of the eleven
# thousand are: a third of the time of this.
$(VENV)/.installed-all: pyproject.toml | $(VENV)/.made
	@$(PYTHON_IN_VENV) -m pip install --quiet --no-compile --disable-pip-version-check --editable ".[test,docs]"
	@touch $(VENV)/.installed $(VENV)/.installed-test $(VENV)/.installed-docs $@
