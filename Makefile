# Two commands do everything on a fresh machine: `make demo` and `make test`.
PYTHON ?= python3
BIN := .venv/bin
STAMP := .venv/.up-to-date
# All that is about kernels.
INTERPRETED := $(filter-out %_gains.py %_sections.py %_sound.py %_wellpath.py, $(wildcard tests/test_estimator_*.py))

.PHONY: demo test prepared test-all test-interpreted check bench accuracy proto clean

demo: $(STAMP)
	$(BIN)/vsensor demo $(ARGS)

# A third of the time is waiting for daemons: four at a time keep two processors busy; a library's threads on top of that
# would wait for one another in vain. The kernels as they stand, without the compiler, are tested beside all else, to which
# that gives way (nice); each that is slow for that is not stuck: more patience than the rest has.
test: export OPENBLAS_NUM_THREADS := 1
test: $(STAMP)
	@$(MAKE) --no-print-directory --jobs=2 test-all test-interpreted

# What all tests need is made once, not by each of those that run at a time: kernels, and the tests as pytest rewrites
# them. Where that fails, a test says why.
prepared: $(STAMP)
	@$(BIN)/vsensor verify recordings/stick_slip.mcap >/dev/null 2>&1 || true
	@PYTHONDONTWRITEBYTECODE= $(BIN)/pytest --collect-only --quiet >/dev/null 2>&1 || true

test-all: prepared
	$(BIN)/pytest --numprocesses=4 --dist=loadfile --no-loadscope-reorder $(ARGS)

test-interpreted: $(STAMP)
	NUMBA_DISABLE_JIT=1 nice $(BIN)/pytest --quiet --numprocesses=1 --timeout=600 $(INTERPRETED) \
	    >.venv/interpreted.txt 2>&1; status=$$?; cat .venv/interpreted.txt; exit $$status

check: $(STAMP)
	$(BIN)/ruff check .
	$(BIN)/ruff format --check .
	$(BIN)/mypy
	$(BIN)/lint-imports
	$(BIN)/python -m pip check

bench: $(STAMP)
	$(BIN)/vsensor bench $(ARGS)

accuracy: $(STAMP)
	$(BIN)/python -m tests.accuracy docs/images > docs/accuracy.md.new && mv docs/accuracy.md.new docs/accuracy.md

proto: $(STAMP)
	$(BIN)/python -m grpc_tools.protoc --plugin=protoc-gen-mypy=$(BIN)/protoc-gen-mypy \
	    -I. --python_out=. --mypy_out=. vsensor/messages/vsensor.proto

clean:
	rm -rf .venv

$(STAMP): pyproject.toml constraints.txt
	@echo "Setting up .venv: a minute or two, once."
	$(PYTHON) -m venv .venv
	$(BIN)/python -m pip install --quiet --no-compile --constraint constraints.txt --editable '.[dev]'
	@# By as many processors as there are, which pip does not. Left to the first import it would be done at each start
	@# where Python is told to write none (PYTHONDONTWRITEBYTECODE).
	$(BIN)/python -m compileall -q -j 0 -x '/tests/' .venv/lib vsensor
	touch $@
