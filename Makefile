# Each target sets itself up: a fresh machine needs Python 3.11 or newer and nothing else.
VENV := .venv
PY := $(VENV)/bin/python
# The first of these that really is 3.11 or newer.
PYTHON ?= $(shell for p in python3 python3.13 python3.12 python3.11 python; do \
	$$p -c 'import sys; sys.exit(sys.version_info < (3, 11))' >/dev/null 2>&1 && { echo $$p; break; }; done)

.PHONY: demo test test-quick test-everywhere soak attack notebooks docs check wheel wheel-with-kernels clean

demo: $(VENV)/.ready
	$(VENV)/bin/robust-ik demo --output out/demo.html

test: $(VENV)/.ready
	$(PY) -m pytest -n auto --dist loadfile

# For people at work: under two minutes on two idle cores.
test-quick: $(VENV)/.ready
	$(PY) -m pytest -n auto --dist loadfile --quick tests

# As if on other machines: other routines of BLAS, NumPy and C, other compiled code, starts moved, load on all cores.
test-everywhere: $(VENV)/.ready
	$(PY) -m tests.everywhere

soak: $(VENV)/.ready
	$(PY) -m tests.soak

attack: $(VENV)/.ready
	$(PY) -m tests.attack

# Every notebook run, and kept as a page without scripts.
notebooks: $(VENV)/.ready
	$(PY) -m benchmarks.notebooks

# The documentation site in out/docs: every warning is an error, every link is followed, nothing comes from elsewhere.
docs: $(VENV)/.ready
	$(VENV)/bin/sphinx-build -q -E -W --keep-going -c docs/site -d out/doctrees . out/docs
	$(PY) docs/site/check_links.py out/docs
	@echo "the documentation is in out/docs/docs/index.html"

check: $(VENV)/.ready
	$(VENV)/bin/ruff check .
	$(VENV)/bin/ruff format --check .
	$(VENV)/bin/mypy
	$(VENV)/bin/lint-imports

wheel: $(VENV)/.ready
	rm -rf dist
	$(PY) -m build --wheel

# For the Python, the system and the level of processors that it names: nothing is compiled where it is installed.
wheel-with-kernels: $(VENV)/.ready
	rm -rf dist out/kernels
	$(PY) .ci/ship_kernels.py out/kernels
	ROBUST_IK_KERNELS=$(CURDIR)/out/kernels $(PY) -m build --wheel

clean:
	rm -rf $(VENV) out dist

$(VENV)/.ready: pyproject.toml
	@test -n "$(PYTHON)" || { echo "Python 3.11 or newer is needed; set PYTHON=/path/to/python"; exit 1; }
	test -x $(PY) || $(PYTHON) -m venv $(VENV)
	$(PY) -m pip install --quiet --editable '.[dev]'
	@touch $@
