# What there is to run. Everything is set up on the way: an environment in .venv, clean ones with other
# versions of Blender in .venvs, system libraries where they are missing. The second run is quick.

.NOTPARALLEL:
.DELETE_ON_ERROR:
.PHONY: demo test lint test-solver test-blender test-versions extension gui-test bench fuzz mutation gallery clean

PYTHON := .venv/bin/python
TYPES := .venvs/types/bin/python
WORKERS := $(shell n=$$(nproc); echo $$((n < 8 ? n : 8)))
# A process a core, each with whole files; BLAS threads of their own would only be in each other's way.
PYTEST := OPENBLAS_NUM_THREADS=1 $(PYTHON) -m pytest --timeout=300 -n $(WORKERS) --dist loadfile
SETUP := Makefile pyproject.toml scripts/build/setup_env.sh scripts/build/requirements.py scripts/build/system_libraries.sh
SHIPPED := __init__.py blender_manifest.toml pyproject.toml scripts/build/build_extension.py scripts/build/help_pages.py \
           scripts/build/api_pages.py $(shell find solver cmc_addon -name '*.py') $(shell find docs -name '*.md')
BLENDERS := .venvs/bpy-4.5/ready .venvs/bpy-5.0/ready .venvs/bpy-5.2/ready

# Form one of the plans and render it: build/demo/.
demo: .venv/ready
	$(PYTHON) -m scripts.gallery.demo

# Everything that needs no window and no patience; its last line is pytest's.
test: lint test-solver test-blender

# Types of the solver, and of the add-on against stubs of bpy in an environment of their own.
lint: .venv/ready .venvs/types/ready
	$(PYTHON) -m ruff check .
	$(PYTHON) -m pyright --pythonpath $(PYTHON)
	$(PYTHON) -m pyright -p scripts/build/pyright-addon.json --pythonpath $(TYPES)

test-solver: .venv/ready
	$(PYTEST) tests/solver tests/test_layers.py

# A process of its own: in Blender the solver is a part of the extension.
test-blender: .venv/ready dist/here $(BLENDERS)
	$(PYTEST) tests/blender

# All of these tests in the oldest and the newest Blender too, in environments that have everything.
test-versions: .venvs/full-4.5/ready .venvs/full-5.2/ready
	for version in 4.5 5.2; do .venvs/full-$$version/bin/python -m pytest --timeout=300 tests/blender \
	  --ignore tests/blender/test_extension.py || exit 1; done

# The zips to install in Blender, one a platform: dist/.
extension: .venv/ready
	$(PYTHON) scripts/build/build_extension.py --all

# The documentation as HTML, with a page for each public name and a search page: build/docs/.
.PHONY: docs
docs: .venv/ready
	$(PYTHON) scripts/build/help_pages.py

# Stories in a real Blender with a window, in a Debian of its own, with the extension built for it and installed;
# pictures in build/gui/. Needs root; CMC_GUI_ROOT is where that Debian is (.venvs/gui-root).
gui-test: .venv/ready
	tests/gui/run.sh

bench: .venv/ready
	$(PYTHON) -m pytest benchmarks -k "not sizes"

# Random plans, meshes, jobs and damaged files: a table of what came of them (CONTRIBUTING.md); under an hour.
N := 10000
SEED := 1
fuzz: .venv/ready
	$(PYTHON) -m tests.fuzz -n $(N) --seed $(SEED)

# How many small faults the tests notice, a room (CONTRIBUTING.md): about an hour on one processor.
mutation: .venv/ready
	$(PYTHON) -m scripts.mutation.mutate

# In Blender: random sequences of the operators with undo, and the memory of 500 solves; a quarter of an hour.
.PHONY: fuzz-blender faults
CALLS := 1000
fuzz-blender: .venv/ready
	OPENBLAS_NUM_THREADS=1 $(PYTHON) -m tests.fuzz.operators --calls $(CALLS)
	OPENBLAS_NUM_THREADS=1 $(PYTHON) -m tests.fuzz.solves

# Batches of 50 plans killed at 20 random moments, by both command lines; five minutes.
faults: .venv/ready
	$(PYTHON) -m tests.faults.kill

# The pictures of docs/, and the tables of its pages; those of the window by the stories of gui-test, where it can run.
gallery: .venv/ready
	$(PYTHON) -m scripts.tables.measure_faces --write
	$(PYTHON) -m scripts.tables.measure_fits --write
	$(PYTHON) -m scripts.tables.measure_approximation --write
	$(PYTHON) -m scripts.tables.measure_spans --write
	$(PYTHON) -m scripts.tables.measure_symmetry --write
	$(PYTHON) -m scripts.tables.measure_periods --write
	$(PYTHON) -m scripts.tables.measure_bubbles --write
	$(PYTHON) -m scripts.tables.measure_nets --write
	$(PYTHON) -m scripts.gallery.render_gallery
	$(PYTHON) -m scripts.gallery.gallery_window

# What was made from the sources; the environments stay.
clean:
	rm -rf build dist .pytest_cache .ruff_cache
	find . -path './.venv*' -prune -o -name __pycache__ -prune -exec rm -rf {} +

# The zip for this machine only, for the tests.
dist/here: .venv/ready $(SHIPPED)
	$(PYTHON) scripts/build/build_extension.py
	basename "$$(ls -t dist/*.zip | head -n 1)" >$@

.venv/ready: $(SETUP)
	scripts/build/setup_env.sh $(@D) 3.11 base fast intrinsic blender test

.venvs/bpy-4.5/ready .venvs/bpy-5.0/ready: .venvs/%/ready: $(SETUP)
	scripts/build/setup_env.sh $(@D) 3.11 $*

.venvs/types/ready: $(SETUP) scripts/build/relax_bpy_types.py
	scripts/build/setup_env.sh $(@D) 3.11 base types
	$(TYPES) scripts/build/relax_bpy_types.py $(@D)

.venvs/full-4.5/ready: $(SETUP)
	scripts/build/setup_env.sh $(@D) 3.11 base fast intrinsic test bpy-4.5

.venvs/full-5.2/ready: $(SETUP)
	scripts/build/setup_env.sh $(@D) 3.13 base fast intrinsic test bpy-5.2

# Blender 5.2 runs on Python 3.13, which not every machine has; tests/blender/test_extension.py says so.
.venvs/bpy-5.2/ready: $(SETUP)
	if scripts/build/find_python.sh 3.13; then scripts/build/setup_env.sh $(@D) 3.13 bpy-5.2; else \
	  echo "No Python 3.13 on PATH or in ~/.pyenv/versions: the tests in Blender 5.2 are not run."; fi
