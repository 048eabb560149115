PYTHON ?= python3
BIN := .venv/bin
READY := .venv/.ready

.PHONY: demo test deep check docs bench lock clean

demo: $(READY)
	$(BIN)/mjfriction demo --out demo_out

test: $(READY)
	OMP_NUM_THREADS=1 OPENBLAS_NUM_THREADS=1 $(BIN)/python -m pytest --numprocesses 2 --dist loadfile

# Whole diagnoses and simulations that take too long for the tests.
deep: $(READY)
	OMP_NUM_THREADS=1 OPENBLAS_NUM_THREADS=1 $(BIN)/python -m pytest --numprocesses 2 --dist loadfile -m deep

check: $(READY)
	$(BIN)/ruff check .
	$(BIN)/ruff format --check .
	$(BIN)/mypy

docs: $(READY)
	$(BIN)/python -m scripts.make_docs
	$(BIN)/python -m scripts.law_pages
	$(BIN)/python -m scripts.api_page
	MUJOCO_GL=egl $(BIN)/python -m scripts.robot_pages
	$(BIN)/python -m mkdocs build

# Over an hour: two hundred cases, and two other tools on some of them.
bench: deep
	$(BIN)/python -m pip install --quiet --require-hashes -r requirements-bench.lock
	$(BIN)/python -m scripts.bench
	$(BIN)/python -m scripts.hidden_effects --cases 200 --beside 60
	$(BIN)/python -m scripts.five_cases
	$(BIN)/python -m scripts.long_logs
	test -z "$$MJFRICTION_DATA" || { $(BIN)/python -m scripts.identify_peers && $(BIN)/python -m scripts.real_case && \
	  $(BIN)/python -m scripts.real_machines; }

# The lock carries hashes and no index address: pip takes the packages from wherever this machine is set up to.
$(READY): requirements.lock pyproject.toml
	$(PYTHON) -c 'import sys; sys.exit("Python 3.11 or newer is needed, this is " + sys.version.split()[0] + "; try make PYTHON=python3.11" if sys.version_info < (3, 11) else 0)'
	$(PYTHON) -m venv .venv
	$(BIN)/python -m pip install --quiet --require-hashes -r requirements.lock
	$(BIN)/python -m pip install --quiet --no-deps --no-build-isolation --editable .
	touch $(READY)

# Needs uv on the path; the options keep every index address out of the file.
lock:
	uv pip compile pyproject.toml --group dev --universal --python-version 3.11 --generate-hashes \
	  --no-emit-index-url --no-emit-find-links --no-header --no-annotate --output-file requirements.lock
	uv pip compile --group pyproject.toml:bench --constraint requirements.lock --universal --python-version 3.11 \
	  --generate-hashes --no-emit-index-url --no-emit-find-links --no-header --no-annotate \
	  --output-file requirements-bench.lock

clean:
	rm -rf .venv demo_out site .pytest_cache .mypy_cache .ruff_cache .hypothesis
