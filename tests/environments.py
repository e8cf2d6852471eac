"""Creates virtual environments and wheels, by uv within seconds, or by pip if uv fails.

    python tests/environments.py REQUIREMENT...

installs requirements, or options such as `--editable .`, into the environment of this interpreter.
uv is that of this environment: the Makefile installs it if possible. It does not read pip's
configuration, so it may not reach a package index that pip reaches.
"""

from __future__ import annotations

import os
import subprocess
import sys
from pathlib import Path

UV = Path(sys.executable).with_name("uv")
PIP_OPTIONS = ("--quiet", "--disable-pip-version-check")


def create(interpreter: str, folder: Path) -> str:
    """Create an environment without packages; return the path of its interpreter."""
    python = str(folder / "bin" / "python")
    if not _succeeds(str(UV), "venv", "--quiet", "--python", interpreter, str(folder)):
        subprocess.run([interpreter, "-m", "venv", str(folder)], check=True)
    return python


def install(python: str, *requirements: str) -> None:
    """Install requirements into the environment of `python`, without writing bytecode.

    Raises CalledProcessError if neither uv nor pip can install them.
    """
    if not _succeeds(
        *(str(UV), "pip", "install", "--quiet", "--python", python), *requirements
    ):
        pip = (
            sys.executable,
            "-m",
            "pip",
            "--python",
            python,
            "install",
            "--no-compile",
        )
        subprocess.run([*pip, *PIP_OPTIONS, *requirements], check=True)


def build_wheel(source: Path, folder: Path, **environment: str) -> Path:
    """Build the wheel of a project into a folder that has no wheel; return its path.

    `environment` are variables of the build. Raises CalledProcessError if the build fails.
    """
    variables = {**os.environ, **environment}
    if not _succeeds(
        *(str(UV), "build", "--quiet", "--wheel", "--no-create-gitignore"),
        *("--out-dir", str(folder), str(source)),
        variables=variables,
    ):
        pip = (sys.executable, "-m", "pip", "wheel", "--no-deps", *PIP_OPTIONS)
        command = [*pip, "--wheel-dir", str(folder), str(source)]
        subprocess.run(command, check=True, env=variables)
    [wheel] = folder.glob("*.whl")
    return wheel


def _succeeds(*command: str, variables: dict[str, str] | None = None) -> bool:
    """Return whether a command of uv exists and succeeds."""
    if not UV.exists():
        return False
    return subprocess.run(command, check=False, env=variables).returncode == 0


if __name__ == "__main__":
    install(sys.executable, *sys.argv[1:])
