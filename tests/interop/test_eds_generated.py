"""Components of real devices: every readable description is generated, imported and typed.

`RTGEN_EDS_CORPUS` names a folder of further descriptions.
"""

from __future__ import annotations

import os
import subprocess
import sys
from pathlib import Path

import pytest
from type_checkers import check_by_mypy

from rtgen.compiler.compilation import compile_project
from rtgen.compiler.diagnostics import has_errors
from rtgen.compiler.frontends.eds import load as load_eds
from rtgen.compiler.project import load, output
from rtgen.compiler.project.compilation import Compilation

GOLDEN = Path(__file__).parents[3] / "shared" / "golden" / "eds"
FOLDERS = [Path(p) for p in (str(GOLDEN), os.environ.get("RTGEN_EDS_CORPUS", "")) if p]
FILES = sorted(
    path
    for folder in FOLDERS
    for path in folder.rglob("*")
    if path.suffix.lower() in (".eds", ".dcf") and path.is_file()
)
TOGETHER = 60
"""Number of devices in one project: mypy reads their common part once."""

pytestmark = [
    pytest.mark.slow,
    pytest.mark.skipif(
        not FILES, reason="no descriptions at ../shared or RTGEN_EDS_CORPUS"
    ),
]


@pytest.fixture(
    scope="module",
    params=range(0, max(len(FILES), 1), TOGETHER),
    ids=lambda first: f"from {first}",
)
def made(
    request: pytest.FixtureRequest, tmp_path_factory: pytest.TempPathFactory
) -> tuple[Path, Compilation, int]:
    """Return a project of some of the devices, the result of its compilation, and their number."""
    root = tmp_path_factory.mktemp("mass")
    (root / "eds").mkdir()
    (root / "rtgen.toml").write_text(
        '[sources]\npaths = ["eds"]\n'
        '[output]\npackage = "mass"\nskeletons = "src/massnodes"\n'
    )
    count = 0
    for number, path in enumerate(FILES[request.param : request.param + TOGETHER]):
        if not has_errors(load_eds([path], root=path.parent).diagnostics):
            copy = root / "eds" / f"d{number}{path.suffix}"
            copy.write_bytes(path.read_bytes())
            count += 1
    with pytest.MonkeyPatch.context() as patch:
        patch.chdir(root)
        project = load()
        run = compile_project(project)
        assert not run.failed, [d for d in run.diagnostics if has_errors([d])]
        output.write(project, run)
    return root, run, count


@pytest.mark.nightly
def test_every_component_is_made(made: tuple[Path, Compilation, int]) -> None:
    """All modules are imported, and a proxy and a device created of every description."""
    root, _, count = made
    code = (
        "import importlib, json, pkgutil, mass\n"
        "for each in pkgutil.walk_packages(mass.__path__, 'mass.'):\n"
        "    importlib.import_module(each.name)\n"
        "manifest = json.load(open('generated/.rtgen.json'))\n"
        "for name, target in manifest['factories'].items():\n"
        "    module, _, made = target.partition(':')\n"
        "    print(getattr(importlib.import_module(module), made)(name))\n"
    )
    path = os.pathsep.join([str(root / "generated"), str(root / "src")])
    done = subprocess.run(
        [sys.executable, "-c", code],
        cwd=root,
        env=os.environ | {"PYTHONPATH": path},
        capture_output=True,
        text=True,
        check=False,
    )
    assert done.returncode == 0, done.stderr
    assert len(done.stdout.splitlines()) == 2 * count


@pytest.mark.nightly
def test_mypy_strict(made: tuple[Path, Compilation, int]) -> None:
    root, _, _ = made
    search = [root / "generated", root / "src"]
    check_by_mypy([root / "generated/mass", root / "src"], search)
