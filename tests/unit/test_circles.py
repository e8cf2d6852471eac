"""No import cycles across files, including imports for type checkers and inside functions."""

from __future__ import annotations

import ast
from graphlib import CycleError, TopologicalSorter
from pathlib import Path

import pytest

import rtgen

ROOT = Path(rtgen.__file__).parent


def _modules() -> dict[str, Path]:
    found = {}
    for path in ROOT.rglob("*.py"):
        parts = ["rtgen", *path.relative_to(ROOT).with_suffix("").parts]
        if parts[-1] == "__init__":
            parts.pop()
        found[".".join(parts)] = path
    return found


MODULES = _modules()


def _imports(name: str) -> set[str]:
    """Return the modules of rtgen that a module imports anywhere in its text."""
    found = set()
    for node in ast.walk(ast.parse(MODULES[name].read_text(encoding="utf-8"))):
        if isinstance(node, ast.Import):
            found.update(alias.name for alias in node.names)
        elif isinstance(node, ast.ImportFrom) and node.module is not None:
            for alias in node.names:
                inner = f"{node.module}.{alias.name}"
                found.add(inner if inner in MODULES else node.module)
    return found & MODULES.keys() - {name}


@pytest.mark.parametrize(
    "package",
    [
        *(
            "backends",
            "cli",
            "diagnostics",
            "diff",
            "facts",
            "frontends",
            "layouts",
            "lint",
        ),
        *("lowering", "model", "project", "runtime", "small_runtime", "systems"),
        "typemap",
    ],
)
def test_no_circle_across_files(package: str) -> None:
    prefix = f"rtgen.{package}"
    names = [n for n in MODULES if n == prefix or n.startswith(f"{prefix}.")]
    assert names
    try:
        TopologicalSorter({name: _imports(name) for name in names}).prepare()
    except CycleError as circle:
        pytest.fail(" -> ".join(circle.args[1]))


def test_no_circle_across_packages_of_the_compiler() -> None:
    """Nor with the packages around them; those of the runtime are examined above."""
    runtime = ("rtgen.runtime", "rtgen.small_runtime")
    names = [n for n in MODULES if not n.startswith(runtime)]
    assert {"rtgen", "rtgen.api", "rtgen.compiler", "rtgen.cli.compiling.cached"} <= {
        *names
    }
    try:
        TopologicalSorter({n: _imports(n) & {*names} for n in names}).prepare()
    except CycleError as circle:
        pytest.fail(" -> ".join(circle.args[1]))
