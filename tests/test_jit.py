"""Parts of kernels are called by kernels alone: a call from Python would end the process without a word.

And all that Python calls is compiled before a daemon says that it is ready.
"""

import ast
import subprocess
import sys
from functools import cache
from pathlib import Path

import pytest

from vsensor.jit import COMPILED

ROOT = Path(__file__).parents[1]


@cache
def modules() -> dict[str, ast.Module]:
    """All of ours by name, read where they are asked for: it takes seconds."""
    return {
        ".".join(path.relative_to(ROOT).with_suffix("").parts): ast.parse(path.read_text(encoding="utf-8"))
        for folder in ("vsensor", "tests")
        for path in (ROOT / folder).rglob("*.py")
    }


def decorated(module: ast.Module, *names: str) -> list[ast.FunctionDef]:
    return [
        node
        for node in module.body
        if isinstance(node, ast.FunctionDef)
        and any(isinstance(by, ast.Name) and by.id in names for by in node.decorator_list)
    ]


@cache
def all_parts() -> set[tuple[str, str]]:
    return {(name, part.name) for name, module in modules().items() for part in decorated(module, "inlined")}


def known(name: str, module: ast.Module) -> tuple[dict[str, tuple[str, str]], dict[str, str]]:
    """What parts, and what modules, are called within a module."""
    parts = {part: (of, part) for of, part in all_parts() if of == name}
    called = {}
    for node in ast.walk(module):
        if isinstance(node, ast.ImportFrom) and node.module:
            for one in node.names:
                if (node.module, one.name) in all_parts():
                    parts[one.asname or one.name] = (node.module, one.name)
                if f"{node.module}.{one.name}" in modules():
                    called[one.asname or one.name] = f"{node.module}.{one.name}"
    return parts, called


def called_from_python(name: str, module: ast.Module) -> set[tuple[str, str]]:
    parts, called = known(name, module)
    kernels = decorated(module, "compiled", "inlined")
    found = set()
    for node in (inner for outer in module.body if outer not in kernels for inner in ast.walk(outer)):
        match node:
            case ast.Call(func=ast.Name(id=part)) if part in parts:
                found.add(parts[part])
            case ast.Call(func=ast.Attribute(value=ast.Name(id=of), attr=part)) if of in called:
                found.add((called[of], part))
    return found & all_parts()


def test_python_calls_no_part_of_a_kernel() -> None:
    assert len(all_parts()) > 50
    for name, module in modules().items():
        assert called_from_python(name, module) == set(), name


def test_such_a_call_would_be_found() -> None:
    by_name = ast.parse("from vsensor.estimator.inputs import enter\nenter(1)")
    by_module = ast.parse("from vsensor.estimator import inputs\ndef f():\n    inputs.enter(1)")
    for module in (by_name, by_module):
        assert called_from_python("any", module) == {("vsensor.estimator.inputs", "enter")}


LIFE = """
import importlib, pkgutil
from numba.core.registry import CPUDispatcher
from tests.rigs import SHORT, samples, simulated
from vsensor import estimator
from vsensor.estimator.known import Known
from vsensor.service.engine import Engine
from vsensor.service.profile import Profiler

def compiled():
    names = (module.name for module in pkgutil.iter_modules(estimator.__path__))
    modules = [importlib.import_module(f"vsensor.estimator.{name}") for name in names]
    kernels = {k for m in modules for k in vars(m).values() if isinstance(k, CPUDispatcher)}
    return {k.py_func.__name__ for k in kernels if k.signatures}

feed = samples(simulated(6))
engine = Engine(SHORT)
Profiler(SHORT, engine.estimator)
ready = compiled()
for topic, sample in feed:
    for tick, _ in engine.take(topic, sample):
        if tick.number == 150:
            engine.estimator.lengthen(9.0)
for name, asked in vars(Known).items():
    if isinstance(asked, property):
        getattr(engine.estimator, name)
engine.estimator.profile()
engine.estimator.save()
print(sorted(compiled() - ready))
"""


@pytest.mark.skipif(not COMPILED, reason="nothing is compiled")
def test_all_that_is_called_while_it_runs_is_compiled_at_the_start() -> None:
    """A kernel that was not once held up a loop that had said it was ready, by 4 s."""
    done = subprocess.run([sys.executable, "-c", LIFE], capture_output=True, text=True, check=True, cwd=ROOT)
    assert done.stdout == "[]\n"
