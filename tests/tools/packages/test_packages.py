"""Complete sets of definitions as used for robots: packages import in any order and type-check.

`openrtm` adds OpenRTM's definitions to the standard interfaces, `openhrp` resembles the definitions
of humanoid simulators and their real-time processes (with names that Python has too), `dds` those
of ROS 2 and DDS.
"""

from __future__ import annotations

import ast
import os
import subprocess
import sys
from collections import Counter
from pathlib import Path

import black
import pytest
from type_checkers import check_by_mypy, check_by_pyright

HERE = Path(__file__).parent
ROOT = HERE.parents[2]
INCLUDE = {
    "openrtm": [ROOT / "specs" / "idl", ROOT / "tests" / "golden" / "idl"],
    "openhrp": [],
    "dds": [HERE / "dds"],
}

# Each module is the first of its package to be imported, then all of them in both orders.
IMPORTING = """
import sys
from importlib import import_module
package, *modules = sys.argv[1:]
def purge():
    for name in [n for n in sys.modules if n == package or n.startswith(package + ".")]:
        del sys.modules[name]
for first in modules:
    purge()
    import_module(first)
for order in (modules, modules[::-1]):
    purge()
    for module in order:
        import_module(module)
"""


@pytest.fixture(scope="module")
def sets(tmp_path_factory: pytest.TempPathFactory) -> dict[str, Path]:
    """Return the folder of the generated package of each set."""
    folders = {}
    for name, include in INCLUDE.items():
        folder = tmp_path_factory.mktemp(name)
        paths = [HERE / name, *include[:1]] if name == "openrtm" else [HERE / name]
        settings = (
            f"[sources]\npaths = {[str(p) for p in paths]}\n"
            f"include = {[str(p) for p in include]}\n[output]\npackage = '{name}_set'\n"
        )
        (folder / "rtgen.toml").write_text(settings, encoding="utf-8")
        command = [sys.executable, "-m", "rtgen", "generate", "--no-cache", "--quiet"]
        done = subprocess.run(command, cwd=folder, capture_output=True, text=True)
        assert done.returncode == 0, done.stderr
        folders[name] = folder / "generated" / f"{name}_set"
    return folders


def modules_of(package: Path) -> list[str]:
    """Return the dotted names of a package's modules."""
    files = sorted(package.rglob("*.py"))
    parts = (f.relative_to(package.parent).with_suffix("").parts for f in files)
    return [".".join(p[:-1] if p[-1] == "__init__" else p) for p in parts]


@pytest.mark.nightly
@pytest.mark.parametrize("name", INCLUDE)
def test_modules_import_in_any_order(sets: dict[str, Path], name: str) -> None:
    package = sets[name]
    modules = modules_of(package)
    assert len(modules) > 10
    command = [sys.executable, "-W", "error", "-c", IMPORTING, package.name, *modules]
    environment = {**os.environ, "PYTHONPATH": str(package.parent)}
    done = subprocess.run(command, env=environment, capture_output=True, text=True)
    assert done.returncode == 0, done.stderr


@pytest.mark.sampled(1)
@pytest.mark.parametrize("name", INCLUDE)
def test_a_package_imports_its_own_modules_relatively(
    sets: dict[str, Path], name: str
) -> None:
    package = sets[name]
    allowed = {"__future__", "rtgen", *sys.stdlib_module_names}
    for file in package.rglob("*.py"):
        depth = len(file.relative_to(package).parts)
        for node in ast.walk(ast.parse(file.read_text(encoding="utf-8"))):
            assert not isinstance(node, ast.Import), file
            if isinstance(node, ast.ImportFrom):
                top = (node.module or "").partition(".")[0]
                assert node.level <= depth if node.level else top in allowed, file


@pytest.mark.nightly
@pytest.mark.slow
@pytest.mark.parametrize("name", INCLUDE)
def test_text_is_as_black_has_it(sets: dict[str, Path], name: str) -> None:
    mode = black.Mode(target_versions={black.TargetVersion.PY311})
    for file in sorted(sets[name].rglob("*.py")):
        text = file.read_text(encoding="utf-8")
        assert black.format_str(text, mode=mode) == text, file


@pytest.mark.slow
def test_mypy_finds_nothing(sets: dict[str, Path]) -> None:
    check_by_mypy(sets.values(), [package.parent for package in sets.values()])


@pytest.mark.nightly
def test_pyright_finds_nothing(sets: dict[str, Path], tmp_path: Path) -> None:
    check_by_pyright(sets.values(), tmp_path)


def test_modules_of_tests_have_names_of_their_own() -> None:
    """Pytest imports them, and they import each other, by their names alone."""
    tests = [*(ROOT / "tests").rglob("test_*.py")]
    folders = {file.parent for file in tests if "cases" not in file.parts}
    files = [file for folder in folders for file in folder.glob("*.py")]
    names = Counter(file.name for file in files)
    shared = ("conftest.py", "__init__.py")
    assert not [n for n, count in names.items() if count > 1 and n not in shared]
