# Two commands do everything on a fresh machine: `make demo` and `make test`.
PYTHON ?= python3
BIN := .venv/bin
STAMP := .venv/.up-to-date

.PHONY: demo test check bench accuracy proto clean

demo: $(STAMP)
	$(BIN)/vsensor demo $(ARGS)

test: $(STAMP)
	$(BIN)/pytest --numprocesses=2 --dist=loadfile $(ARGS)
	NUMBA_DISABLE_JIT=1 $(BIN)/pytest --quiet --numprocesses=2 tests/test_estimator_*.py

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
	$(BIN)/python -m pip install --quiet --constraint constraints.txt --editable '.[dev]'
	touch $@
