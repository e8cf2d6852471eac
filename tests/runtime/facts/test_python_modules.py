"""The names of modules that a project must not hide: complete, and the same everywhere."""

from __future__ import annotations

import re
import shutil
import subprocess
import sys
import tomllib
from importlib import metadata
from pathlib import Path

import pytest
from rtgen_sources import imports, sources

from rtgen.facts.python_modules import LIBRARIES, MIDDLEWARE, STANDARD, owner

ROOT = Path(__file__).parents[3]
PROJECTS = (ROOT, ROOT / "runtime")
DEVELOPMENT = {"bench", "check", "docs", "release", "test"}
"""Extras for those who work on rtgen, or whose programs run in processes of their own."""


def requirements() -> list[str]:
    """Return the distributions that rtgen, its runtime and their extras require."""
    lines: list[str] = []
    for folder in PROJECTS:
        text = (folder / "pyproject.toml").read_text(encoding="utf-8")
        project = tomllib.loads(text)["project"]
        extras = project["optional-dependencies"]
        lines += project["dependencies"]
        lines += (r for name in extras.keys() - DEVELOPMENT for r in extras[name])
    found = (re.match(r"[\w.-]+", line) for line in lines)
    return sorted({match[0] for match in found if match} - {"rtgen"})


@pytest.mark.parametrize("distribution", requirements())
def test_modules_of_requirements_are_known(distribution: str) -> None:
    try:
        files = metadata.distribution(distribution).files or []
    except metadata.PackageNotFoundError:
        pytest.skip(f"{distribution} is not installed")
    modules = {
        file.parts[0].partition(".")[0]
        for file in files
        if file.suffix in (".py", ".so", ".pyd") and ".." not in file.parts
    }
    public = {m for m in modules if m.isidentifier() and not m.startswith("_")}
    unknown = {m for m in public if owner(m) is None}
    # The wheel's modules with data, and stubs that omniidl made of omniORB's own IDL.
    assert not {m for m in unknown if not m.endswith(("_idl", "_be", "omniorb"))}


@pytest.mark.sampled(0)
def test_modules_that_rtgen_imports_are_known() -> None:
    imported: set[str] = set()
    for path, file in sources().items():
        if path.startswith("examples/"):  # applications, in the wheel alone
            continue
        imported |= {module.partition(".")[0] for module, _ in imports(file)}
    assert len(imported) > 80
    assert not {name for name in imported if owner(name) is None} - {"__future__"}


def test_each_name_has_one_owner() -> None:
    assert LIBRARIES.isdisjoint(STANDARD)
    assert MIDDLEWARE.isdisjoint(STANDARD | LIBRARIES)
    assert owner("queue") == "Python"
    assert owner("click") == owner("rtgen") == "rtgen and its requirements"
    assert owner("RTC") == "OpenRTM"
    assert owner("robots") is None


PYTHONS = [p for n in range(11, 15) if (p := shutil.which(f"python3.{n}"))]


def test_public_names_do_not_depend_on_the_interpreter() -> None:
    """A component gets the same skeleton on each version of Python."""
    code = "import sys; print(*sys.stdlib_module_names)"
    for python in {sys.executable, *PYTHONS}:
        run = subprocess.run([python, "-c", code], capture_output=True, text=True)
        if run.returncode:  # a link of a version manager, without the version
            continue
        public = {name for name in run.stdout.split() if not name.startswith("_")}
        assert public <= STANDARD, python
    removed = {"asyncore", "cgi", "distutils", "imp", "telnetlib"}
    assert removed | {"annotationlib", "compression"} <= STANDARD
