"""Parts of kernels are called by kernels alone: a call from Python would end the process without a word."""

import ast
from pathlib import Path

ROOT = Path(__file__).parents[1]
MODULES = {
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


PARTS = {(name, part.name) for name, module in MODULES.items() for part in decorated(module, "inlined")}


def known(name: str, module: ast.Module) -> tuple[dict[str, tuple[str, str]], dict[str, str]]:
    """What parts, and what modules, are called within a module."""
    parts = {part: (of, part) for of, part in PARTS if of == name}
    modules = {}
    for node in ast.walk(module):
        if isinstance(node, ast.ImportFrom) and node.module:
            for one in node.names:
                if (node.module, one.name) in PARTS:
                    parts[one.asname or one.name] = (node.module, one.name)
                if f"{node.module}.{one.name}" in MODULES:
                    modules[one.asname or one.name] = f"{node.module}.{one.name}"
    return parts, modules


def called_from_python(name: str, module: ast.Module) -> set[tuple[str, str]]:
    parts, modules = known(name, module)
    kernels = decorated(module, "compiled", "inlined")
    found = set()
    for node in (inner for outer in module.body if outer not in kernels for inner in ast.walk(outer)):
        match node:
            case ast.Call(func=ast.Name(id=part)) if part in parts:
                found.add(parts[part])
            case ast.Call(func=ast.Attribute(value=ast.Name(id=of), attr=part)) if of in modules:
                found.add((modules[of], part))
    return found & PARTS


def test_python_calls_no_part_of_a_kernel() -> None:
    assert len(PARTS) > 50
    for name, module in MODULES.items():
        assert called_from_python(name, module) == set(), name


def test_such_a_call_would_be_found() -> None:
    by_name = ast.parse("from vsensor.estimator.inputs import enter\nenter(1)")
    by_module = ast.parse("from vsensor.estimator import inputs\ndef f():\n    inputs.enter(1)")
    for module in (by_name, by_module):
        assert called_from_python("any", module) == {("vsensor.estimator.inputs", "enter")}
