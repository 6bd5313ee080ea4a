# make benchmark, make test: each makes its own virtual environment where there is none.
PYTHON ?= python3
VENV ?= .venv
BIN := $(VENV)/bin
STAMP := $(VENV)/.installed
export OMP_NUM_THREADS = 1
export OPENBLAS_NUM_THREADS = 1
# Seeds of the benchmark: SEEDS=20 is the full one.
SEEDS ?= 5

.PHONY: benchmark test test-all test-wheel docs fuzz sanitize lint format clean

$(STAMP): pyproject.toml constraints.txt
	$(PYTHON) -m venv $(VENV)
	$(BIN)/python -m pip install --quiet --constraint constraints.txt --editable '.[scan,peers,notebooks,docs,test,lint]'
	touch $@

benchmark: $(STAMP)
	$(BIN)/pen-mhe benchmark --output results --seeds $(SEEDS)

test: $(STAMP)
	$(BIN)/python -m pytest -m 'not slow' -n 2 --dist worksteal

test-all: $(STAMP)
	$(BIN)/python -m pytest -n 2 --dist worksteal

# The wheel in an environment of its own, away from the checkout: make test-wheel PYTHON=python3.13
test-wheel:
	rm -rf build/wheel
	$(PYTHON) -m venv build/wheel/venv
	build/wheel/venv/bin/python -m pip wheel --quiet --no-deps --wheel-dir build/wheel .
	build/wheel/venv/bin/python -m pip install --quiet --constraint constraints.txt build/wheel/*.whl
	cd build/wheel && venv/bin/python -I ../../tests/wheel_program.py && venv/bin/pen-mhe --version

# The site of README, docs and notebooks, from what is here: build/docs/index.html. A warning is an error.
docs: $(STAMP)
	rm -rf build/docs build/doctrees
	$(BIN)/python -m sphinx --quiet --fail-on-warning --keep-going \
		--conf-dir docs/site --doctree-dir build/doctrees . build/docs

# Every reader of files, for FUZZ_S seconds each, guided by coverage: make fuzz FUZZ_S=600 FUZZ=csv
FUZZ_S ?= 60
FUZZ ?= pen turntable claims pen_text csv own_csv parquet foreign checked merged json of_pen asked truth workbook archive bag dpoint array scan run results journal
FUZZER := $(VENV)/.fuzzer
$(FUZZER): $(STAMP)
	$(BIN)/python -m pip install --quiet --constraint constraints.txt --editable '.[fuzz]'
	touch $@

fuzz: $(FUZZER)
	set -e; for reader in $(FUZZ); do \
		$(BIN)/python -m tests.fuzz $$reader --runs -1 --seconds $(FUZZ_S); \
	done

# All our C under ASan and UBSan: make sanitize SANITIZE=--quick takes a part of it.
SANITIZE ?=
sanitize: $(STAMP)
	$(BIN)/python -m tests.sanitize $(SANITIZE)

lint: $(STAMP)
	$(BIN)/ruff check .
	$(BIN)/ruff format --check .
	$(BIN)/mypy

format: $(STAMP)
	$(BIN)/ruff format .
	$(BIN)/ruff check --fix .

clean:
	rm -rf $(VENV) results build dist
