"""The Makefile with a Python that is too old, missing, or not the requested one."""

from __future__ import annotations

import ast
import itertools
import os
import re
import shutil
import subprocess
import sys
from pathlib import Path

import interpreters
import pytest

ROOT = Path(__file__).parents[3]
OLD = "#!/bin/sh\n# Python 3.10, as far as the Makefile asks.\nexit 1\n"

pytestmark = pytest.mark.skipif(shutil.which("make") is None, reason="needs make")


def _script(path: Path, text: str) -> Path:
    path.parent.mkdir(parents=True, exist_ok=True)
    path.write_text(text)
    path.chmod(0o755)
    return path


def _make(folder: Path, *arguments: str) -> subprocess.CompletedProcess[str]:
    shutil.copy(ROOT / "Makefile", folder)
    shutil.copy(ROOT / "pyproject.toml", folder)
    command = ["make", "--no-print-directory", *arguments]
    # Tests may run below a make of several jobs, which must not affect this one.
    env = {k: v for k, v in os.environ.items() if not k.startswith("MAKE")}
    env.pop("MFLAGS", None)
    return subprocess.run(
        command,
        cwd=folder,
        env=env,
        capture_output=True,
        text=True,
        timeout=60,
        check=False,
    )


@pytest.mark.parametrize("python", ["old", "missing"])
def test_a_python_that_does_not_do_is_reported_in_one_line(
    tmp_path: Path, python: str
) -> None:
    old = _script(tmp_path / "old", OLD)
    name = str(old) if python == "old" else "no-such-python"
    done = _make(tmp_path, "demo", f"PYTHON={name}")
    assert done.returncode != 0
    first, *others = done.stderr.splitlines()
    assert first == (
        f"rtgen needs Python 3.11 or later, and '{name}' is none: make PYTHON=python3.11"
    )
    assert all(line.startswith("make") for line in others)
    assert not (tmp_path / ".venv").exists()


def test_an_environment_that_is_too_old_is_made_anew(tmp_path: Path) -> None:
    _script(tmp_path / ".venv/bin/python", OLD)
    (tmp_path / ".venv/demo.stamp").touch()
    done = _make(tmp_path, "-n", "demo", f"PYTHON={sys.executable}")
    assert done.returncode == 0
    assert f"{sys.executable} -m venv .venv" in done.stdout
    assert not (tmp_path / ".venv").exists()


def test_an_environment_of_another_python_is_refused(tmp_path: Path) -> None:
    here = _script(
        tmp_path / ".venv/bin/python", f'#!/bin/sh\nexec {sys.executable} "$@"\n'
    )
    newer = _script(tmp_path / "newer", "#!/bin/sh\necho 3.99\n")
    done = _make(tmp_path, "-n", "demo", f"PYTHON={newer}")
    assert done.returncode != 0
    assert (
        f".venv has another Python than {newer}: run `make clean` first" in done.stderr
    )
    assert here.exists()
    assert _make(tmp_path, "-n", "demo", f"PYTHON={sys.executable}").returncode == 0
    assert _make(tmp_path, "-n", "clean", f"PYTHON={newer}").returncode == 0


def test_each_test_is_run_on_one_interpreter_at_least() -> None:
    """Tests that `make test` excludes run on the further interpreter."""
    text = (ROOT / "Makefile").read_text(encoding="utf-8")
    [own] = re.findall(r"^test: SELECTED = (.+)$", text, re.MULTILINE)
    markers = ("once", "slow", "peer", "random")
    left_out = 0
    for values in itertools.product((False, True), repeat=len(markers)):
        marked = dict(zip(markers, values, strict=True))
        runs = eval(own, {}, marked)
        left_out += not runs
        assert runs or eval(interpreters.SELECTED, {}, marked)
    assert left_out == 1
    once = conftest_folders()
    assert Path("reference") in once
    for tried in (Path(name).relative_to("tests") for name in interpreters.TRIED_ONCE):
        for folder in once:
            assert not folder.is_relative_to(tried)
            assert not tried.is_relative_to(folder)


def conftest_folders() -> set[Path]:
    """Return the folders whose tests are marked as `once`."""
    text = (ROOT / "tests" / "conftest.py").read_text(encoding="utf-8")
    [names] = re.findall(r"^ONCE = (\(.+?^\))$", text, re.MULTILINE | re.DOTALL)
    return {Path(name) for name in ast.literal_eval(names)}
