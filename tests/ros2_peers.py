"""Installations of ROS 2 with rclpy and Fast DDS, as peers of tests, from the package index.

    python tests/ros2_peers.py

makes those that are missing, in `build/ros2`: 63 MB to fetch and 240 MB of disk each, some seconds.
rtgen is installed into each of them from this clone, so that it runs as in a sourced installation.
Its packages exist for CPython 3.11 on Linux (x86-64). Where an installation cannot be made, tests
are skipped, and say why.
"""

from __future__ import annotations

import fcntl
import json
import os
import re
import shutil
import subprocess
import sys
import time
from collections.abc import Iterator
from concurrent.futures import ThreadPoolExecutor
from contextlib import contextmanager
from functools import cache
from pathlib import Path

import environments
import interpreters
import pytest
from patience import PATIENCE

DISTRIBUTIONS = ("jazzy", "kilted")
"""Jazzy has Fast DDS 2, Kilted Fast DDS 3."""
PACKAGES = (
    "rclpy",
    "rmw-fastrtps-cpp",
    "common-interfaces",
    "test-msgs",
    "rosidl-adapter",
    "rosidl-parser",
    "rosidl-generator-type-description",
)
BUILDING = (
    *("ament-cmake", "ament-cmake-core", "ament-cmake-export-definitions"),
    *("ament-cmake-export-dependencies", "ament-cmake-export-include-directories"),
    *("ament-cmake-export-interfaces", "ament-cmake-export-libraries"),
    *("ament-cmake-export-link-flags", "ament-cmake-export-targets"),
    *("ament-cmake-gen-version-h", "ament-cmake-gmock", "ament-cmake-gtest"),
    *("ament-cmake-include-directories", "ament-cmake-libraries", "ament-cmake-pytest"),
    *("ament-cmake-python", "ament-cmake-ros", "ament-cmake-target-dependencies"),
    *("ament-cmake-test", "ament-cmake-version", "ament-index-python", "ament-package"),
    *("rosidl-core-generators", "rosidl-default-generators"),
    *("rosidl-default-runtime", "rosidl-generator-py"),
)
"""What builds packages of interface files besides."""
OF_ONE = {"jazzy": ("python-cmake-module",), "kilted": ("ament-cmake-ros-core",)}
"""What else one distribution has for it."""
COLCON = ("colcon-common-extensions", "empy<4", "setuptools<80")
ROOT = Path(__file__).resolve().parent.parent
OWN = tuple(f"--editable={folder}" for folder in (ROOT / "runtime", ROOT))
FOLDER = ROOT / "build" / "ros2"
PYTHON = "3.11"
_FOLDERS = re.compile(
    r"/opt/python/[\w-]+/(include(?=/)|lib(?=/python[\d.]+/site-packages))"
    r"/python[\d.]+(?:/site-packages)?"
)
_KINDS = {"include": "include", "lib": "purelib"}
_FAILURE_LIFETIME = 600.0
"""Seconds during which a failed installation is not tried again."""
_OWN_VARIABLES = ("ROS_", "RMW_", "RCUTILS_", "AMENT_", "FASTDDS_", "FASTRTPS_")
"""What begins so belongs to another installation of ROS 2."""


class UnavailableError(Exception):
    """An installation cannot be made."""


class Installation:
    """A distribution of ROS 2; nodes in it use Fast DDS on the loopback interface alone."""

    def __init__(self, distribution: str, *, builds: bool = False) -> None:
        self.distribution = distribution
        self.name = f"{distribution}-colcon" if builds else distribution
        self.folder = FOLDER / self.name
        self.python = str(self.folder / "bin" / "python")
        self.rtgen = str(self.folder / "bin" / "rtgen")
        self.share = self.folder / "share"
        """The folder of the packages' interface files."""

    def environment(self, domain: int = 0) -> dict[str, str]:
        """Return the environment variables of a process with nodes in a domain."""
        others = ("PYTHONPATH", "CYCLONEDDS_URI")
        kept = {
            name: value
            for name, value in os.environ.items()
            if not name.startswith(_OWN_VARIABLES) and name not in others
        }
        return {
            **kept,
            "ROS_AUTOMATIC_DISCOVERY_RANGE": "LOCALHOST",
            "ROS_DOMAIN_ID": str(domain),
            "ROS_LOG_DIR": str(FOLDER / "log"),
            "PYTHONUNBUFFERED": "1",
        }

    def start(
        self, script: Path, *arguments: str, domain: int = 0
    ) -> subprocess.Popen[str]:
        """Start a Python script; its output is a pipe of text."""
        return subprocess.Popen(
            [self.python, str(script), *arguments],
            env=self.environment(domain),
            stdin=subprocess.PIPE,
            stdout=subprocess.PIPE,
            text=True,
        )

    def output(
        self, script: Path, *arguments: str, text: str = "", domain: int = 0
    ) -> str:
        """Return the output of a Python script whose input is `text`.

        Raises CalledProcessError, TimeoutExpired.
        """
        return subprocess.run(
            [self.python, str(script), *arguments],
            env=self.environment(domain),
            input=text,
            stdout=subprocess.PIPE,
            text=True,
            check=True,
            timeout=PATIENCE,
        ).stdout


@cache
def installation(distribution: str, *, builds: bool = False) -> Installation:
    """Return an installation, made by the first process that needs it.

    `builds`: it has colcon, and what builds packages. The calling test is skipped where it cannot
    be made.
    """
    try:
        return make(distribution, builds=builds)
    except UnavailableError as error:
        pytest.skip(str(error))


def make(
    distribution: str, *, again: bool = False, builds: bool = False
) -> Installation:
    """Return an installation, which may have to be made.

    `again`: try it also if it failed a short time ago; `builds`: with colcon. Raises
    UnavailableError.
    """
    made = Installation(distribution, builds=builds)
    more = (*BUILDING, *OF_ONE.get(distribution, ())) if builds else ()
    names = (*PACKAGES, *more)
    packages = tuple(f"ros-{distribution}-{name}" for name in names)
    requirements = (*packages, *OWN, *(COLCON if builds else ()))
    stamp = made.folder / "requirements.txt"
    failure = FOLDER / f"{made.name}.failed"
    with _alone(made.name):
        if stamp.exists() and stamp.read_text().split() == list(requirements):
            return made
        if not again and _is_recent(failure):
            raise UnavailableError(failure.read_text())
        try:
            _install(made.folder, requirements)
            _set_folders(made)
        except UnavailableError as error:
            failure.write_text(str(error))
            raise
        stamp.write_text("\n".join(requirements))
        failure.unlink(missing_ok=True)
    return made


def _install(folder: Path, requirements: tuple[str, ...]) -> None:
    own = f"{sys.version_info.major}.{sys.version_info.minor}"
    python = sys.executable if own == PYTHON else interpreters.find(PYTHON)
    if python is None:
        raise UnavailableError(
            f"Python {PYTHON}, which ROS 2 has packages for, is missing"
        )
    shutil.rmtree(folder, ignore_errors=True)
    try:
        environments.install(environments.create(python, folder), *requirements)
    except subprocess.CalledProcessError:
        raise UnavailableError(
            f"{requirements[0]} cannot be installed from the package index"
        ) from None


def _set_folders(made: Installation) -> None:
    """Name the folders of this Python in CMake files, which name those of another machine."""
    code = "import json, sysconfig; print(json.dumps(sysconfig.get_paths()))"
    command = (made.python, "-c", code)
    answer = subprocess.run(command, stdout=subprocess.PIPE, text=True, check=True)
    folders = json.loads(answer.stdout)
    for path in made.share.glob("*/cmake/*.cmake"):
        text = path.read_text(encoding="utf-8")
        changed = _FOLDERS.sub(lambda match: folders[_KINDS[match[1]]], text)
        if changed != text:
            path.write_text(changed, encoding="utf-8")


@contextmanager
def _alone(distribution: str) -> Iterator[None]:
    """Let one process at a time make a distribution."""
    FOLDER.mkdir(parents=True, exist_ok=True)
    with (FOLDER / f"{distribution}.lock").open("w") as lock:
        fcntl.flock(lock, fcntl.LOCK_EX)
        yield


def _is_recent(file: Path) -> bool:
    return file.exists() and time.time() - file.stat().st_mtime < _FAILURE_LIFETIME


def main() -> int:
    """Make all, each beside the others. The exit code is 1 if one cannot be made."""
    # A package index that does not answer is not waited for.
    os.environ.update(UV_HTTP_TIMEOUT="20", PIP_DEFAULT_TIMEOUT="20", PIP_RETRIES="1")
    code = 0
    with ThreadPoolExecutor() as pool:
        tried = {d: pool.submit(make, d, again=True) for d in DISTRIBUTIONS}
    for distribution, result in tried.items():
        error = result.exception()
        if isinstance(error, UnavailableError):
            print(f"{distribution}: {error}", file=sys.stderr)
            code = 1
        elif error is not None:
            raise error
    return code


if __name__ == "__main__":
    raise SystemExit(main())
