"""Builds the wheel and runs the fast tests on it with every supported interpreter found."""

from __future__ import annotations

import os
import shutil
import subprocess
import sys
import tempfile
from pathlib import Path

SUPPORTED = ("3.11", "3.12", "3.13")
ROOT = Path(__file__).resolve().parent.parent

TRIED_ONCE = ("tests/interop", "tests/fuzz")
"""Comparisons with peers and random inputs are the same on each interpreter."""


def find(version: str) -> str | None:
    """The path of a working interpreter of that version, on the path or of pyenv, or None."""
    pyenv = Path(os.environ.get("PYENV_ROOT") or Path.home() / ".pyenv")
    candidates = [shutil.which(f"python{version}")]
    candidates += map(
        str, sorted(pyenv.glob(f"versions/{version}.*/bin/python{version}"))
    )
    code = "import sys, venv, ensurepip; print('%d.%d' % sys.version_info[:2])"
    for candidate in filter(None, candidates):
        answer = subprocess.run(
            [candidate, "-c", code], capture_output=True, text=True, check=False
        )
        if answer.stdout.strip() == version:
            return candidate
    return None


def build(folder: Path) -> Path:
    """The wheel of the working tree, made in that folder."""
    command = [sys.executable, "-m", "pip", "wheel", "--quiet", "--no-deps"]
    command += ["--disable-pip-version-check", "--wheel-dir", str(folder), str(ROOT)]
    subprocess.run(command, check=True)
    return next(folder.glob("rtgen-*.whl"))


def try_on(interpreter: str, wheel: Path, folder: Path) -> int:
    """The exit code of the fast tests on the wheel in an environment of its own."""
    subprocess.run([interpreter, "-m", "venv", str(folder)], check=True)
    python = folder / "bin" / "python"
    install = [
        str(python),
        "-m",
        "pip",
        "install",
        "--quiet",
        "--disable-pip-version-check",
    ]
    subprocess.run([*install, f"{wheel}[plot,test]"], check=True)
    tests = [
        str(python),
        "-m",
        "pytest",
        "-q",
        "-n",
        "2",
        "-m",
        "not slow",
        "-p",
        "no:cacheprovider",
        *(f"--ignore={name}" for name in TRIED_ONCE),
    ]
    environment = {
        **os.environ,
        "PATH": f"{folder / 'bin'}{os.pathsep}{os.environ['PATH']}",
    }
    return subprocess.run(tests, cwd=ROOT, env=environment, check=False).returncode


def main() -> int:
    """Exit code 0 if the tests pass on each interpreter found."""
    failed = []
    with tempfile.TemporaryDirectory() as temporary:
        folder = Path(temporary)
        wheel = build(folder)
        for version in SUPPORTED:
            interpreter = find(version)
            if interpreter is None:
                print(f"Python {version}: not found, not tested", flush=True)
                continue
            print(f"Python {version}: the fast tests on {wheel.name}", flush=True)
            if try_on(interpreter, wheel, folder / version) != 0:
                failed.append(version)
    for version in failed:
        print(f"Python {version}: FAILED", file=sys.stderr)
    return 1 if failed else 0


if __name__ == "__main__":
    raise SystemExit(main())
