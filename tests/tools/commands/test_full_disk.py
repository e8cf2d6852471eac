"""Disks that are full or read-only: a small file system of its own, and `/dev/full`."""

from __future__ import annotations

import os
import re
import subprocess
import sys
from collections.abc import Callable, Iterator
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[3]
FULL = Path("/dev/full")
IDL = "module M { struct S { long %s; }; };\n"
SETTINGS = '[sources]\npaths = ["idl"]\n[output]\npackage = "bot"\n'

needs_dev_full = pytest.mark.skipif(not FULL.exists(), reason="there is no /dev/full")


def rtgen(*words: str | Path, folder: Path = ROOT, **options: object) -> str:
    """Return the standard error of a command that fails because of its environment."""
    done = subprocess.run(
        [sys.executable, "-m", "rtgen", *map(str, words)],
        cwd=folder,
        stderr=subprocess.PIPE,
        text=True,
        check=False,
        **options,  # type: ignore[call-overload]
    )
    assert done.returncode == 3, done.stderr
    return str(done.stderr)


@pytest.fixture
def small(tmp_path: Path) -> Iterator[Callable[[str], None]]:
    """Yield a function that remounts a project's file system of one megabyte with other options."""
    folder = tmp_path / "small"
    folder.mkdir()

    def mount(*words: str) -> bool:
        command = ["mount", *words, str(folder)]
        return not subprocess.run(command, capture_output=True, check=False).returncode

    if os.name != "posix" or os.getuid() or not mount("-t", "tmpfs", "tmpfs"):
        pytest.skip("only root mounts a file system")
    try:
        (folder / "idl").mkdir()
        (folder / "idl/m.idl").write_text(IDL % "a")
        (folder / "rtgen.toml").write_text(SETTINGS)

        def options(text: str) -> None:
            assert mount("-o", f"remount,{text}")

        yield options
    finally:
        subprocess.run(["umount", str(folder)], check=True)


def generate(folder: Path) -> int:
    command = [sys.executable, "-m", "rtgen", "generate", "-q"]
    return subprocess.run(command, cwd=folder, check=False).returncode


def tree(folder: Path) -> dict[str, bytes]:
    files = (path for path in (folder / "generated").rglob("*") if path.is_file())
    return {str(path): path.read_bytes() for path in files}


def test_a_full_disk_is_named_with_its_file(
    small: Callable[[str], None], tmp_path: Path
) -> None:
    folder = tmp_path / "small"
    assert generate(folder) == 0
    before = tree(folder)
    (folder / "idl/m.idl").write_text(IDL % "b")
    used = sum(path.stat().st_blocks * 512 for path in folder.rglob("*"))
    small(f"size={used}")
    message = rtgen("generate", "-q", folder=folder)
    assert re.fullmatch(
        r"error\[ENV0001\]: generated/\S+: No space left on device\n", message
    )
    assert tree(folder) == before
    small("size=1m")
    assert generate(folder) == 0
    assert tree(folder) != before


@pytest.mark.sampled(0)
def test_a_read_only_disk(small: Callable[[str], None], tmp_path: Path) -> None:
    folder = tmp_path / "small"
    assert generate(folder) == 0
    small("ro")
    assert generate(folder) == 0, "nothing has to be written"
    (tmp_path / "other.idl").write_text("module N { struct T { long a; }; };\n")
    message = rtgen("generate", "-q", tmp_path / "other.idl", folder=folder)
    assert "Read-only file system" in message
    assert "rtgen-new" in rtgen("new", "project", "x", folder=folder)


@pytest.mark.sampled(0)
@needs_dev_full
@pytest.mark.parametrize("option", ["--csv", "--log", "--record"])
def test_results_of_a_run_that_find_no_room(option: str, tmp_path: Path) -> None:
    file = tmp_path / "results.mcap"
    file.symlink_to(FULL)
    system = "specs/navigation/rh3_goal.xml"
    message = rtgen("run", system, "-q", "--until", "1", option, file)
    expected = f"error[ENV0001]: cannot write {file}: No space left on device\n"
    assert message.endswith(f"{expected}1 error\n") or message == expected


@needs_dev_full
@pytest.mark.parametrize(
    "words", [("explain", "IDL0001"), ("inspect", "--json", "specs/idl")], ids=str
)
def test_standard_output_that_finds_no_room(words: tuple[str, ...]) -> None:
    with FULL.open("w") as full:
        message = rtgen(*words, stdout=full)
    expected = "error[ENV0001]: cannot write standard output: No space left on device"
    assert message == f"{expected}\n"
