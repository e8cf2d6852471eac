"""The Makefile with a Python that is too old, missing, or not the requested one."""

from __future__ import annotations

import itertools
import os
import re
import shutil
import subprocess
import sys
from pathlib import Path

import pytest
from interpreters import SELECTED

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
    (folder / "runtime").mkdir(exist_ok=True)
    shutil.copy(ROOT / "runtime" / "pyproject.toml", folder / "runtime")
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


def test_each_test_is_run() -> None:
    """Those that `make test` leaves out are run by `make nightly`, on either interpreter.

    Those that are postponed are run with another seed.
    """
    text = (ROOT / "Makefile").read_text(encoding="utf-8")
    selected = re.findall(r'PYTEST,build/pytest\S*,-m "(.+?)"', text)
    assert len(selected) == 3
    of_commit, nightly = selected[:2], [selected[2], SELECTED]
    names = "nightly", "random", "waits", "left_out", "postponed"
    for values in itertools.product((False, True), repeat=len(names)):
        marked = dict(zip(names, values, strict=True))
        if marked["left_out"] and not marked["nightly"]:
            continue
        # Cases that are left out are neither.
        marked["slow"] = marked["peer"] = not marked["left_out"]
        by_commit = [bool(eval(each, {}, marked)) for each in of_commit]
        assert sum(by_commit) == (not marked["nightly"])
        by_night = any(eval(each, {}, marked) for each in nightly)
        assert any(by_commit) or by_night or marked["postponed"]


@pytest.mark.parametrize("wing", ["", "golden"])
def test_a_wing_is_run_alone(wing: str) -> None:
    command = ["make", "--dry-run", "--no-print-directory", "test", f"WING={wing}"]
    done = subprocess.run(command, cwd=ROOT, capture_output=True, text=True, check=True)
    folders = set(re.findall(r" (tests(?:/\w+)*)(?= )", done.stdout))
    assert f"tests/{wing}".rstrip("/") in folders
    assert ("mypy" in done.stdout) == (not wing)
