"""No import cycles across files, including imports for type checkers and inside functions."""

from __future__ import annotations

from graphlib import CycleError, TopologicalSorter
from pathlib import Path

import pytest
from rtgen_sources import imports, sources


def _modules() -> dict[str, Path]:
    found = {}
    for name, path in sources().items():
        dotted = f"rtgen/{name}".removesuffix(".py").replace("/", ".")
        found[dotted.removesuffix(".__init__")] = path
    return found


MODULES = _modules()


def _imports(name: str) -> set[str]:
    """Return the modules of rtgen that a module imports anywhere in its text."""
    found = set()
    for module, imported in imports(MODULES[name]):
        inner = f"{module}.{imported}"
        found.add(inner if inner in MODULES else module)
    return found & MODULES.keys() - {name}


@pytest.mark.parametrize(
    "package",
    [
        *("api", "cli", "compiler", "facts", "openrtm", "ros2", "runtime"),
        *("small_runtime", "tools", "ui"),
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
    assert {"rtgen.api", "rtgen.compiler", "rtgen.tools.compiling.cached"} <= {*names}
    try:
        TopologicalSorter({n: _imports(n) & {*names} for n in names}).prepare()
    except CycleError as circle:
        pytest.fail(" -> ".join(circle.args[1]))
