"""Outputs of a command differ from each other and from its inputs, by whatever name."""

from __future__ import annotations

import os
from collections.abc import Callable
from pathlib import Path

import pytest

from rtgen.tools.kit.exits import Refusal
from rtgen.tools.kit.files import require_different


def _link(folder: Path) -> Path:
    link = folder / "link.csv"
    link.symlink_to(folder / "values.csv")
    return link


def _through_folder(folder: Path) -> Path:
    (folder / "also").symlink_to(folder, target_is_directory=True)
    return folder / "also" / "values.csv"


def _relative(folder: Path) -> Path:
    return Path(os.path.relpath(folder / "values.csv"))


OTHER_NAMES: list[Callable[[Path], Path]] = [
    lambda folder: folder / "values.csv",
    lambda folder: folder / "x" / ".." / "values.csv",
    _relative,
    _link,
    _through_folder,
]


@pytest.mark.parametrize("other_name", OTHER_NAMES)
def test_other_names_of_a_file(
    tmp_path: Path, other_name: Callable[[Path], Path]
) -> None:
    file = tmp_path / "values.csv"
    file.write_text("1\n")
    (tmp_path / "x").mkdir()
    other = str(other_name(tmp_path))
    with pytest.raises(Refusal, match="would overwrite"):
        require_different({"--csv": other}, file)
    with pytest.raises(Refusal, match="--csv and --plot both write"):
        require_different({"--csv": str(file), "--plot": other})


@pytest.mark.parametrize("name", ["loop", "n" * 300, "\0", "", "a/b"])
def test_names_that_no_file_has_are_left_to_who_opens_them(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, name: str
) -> None:
    monkeypatch.chdir(tmp_path)
    Path("loop").symlink_to("loop")
    require_different({"--csv": name, "--plot": None}, "other.csv")


def test_the_null_device_takes_all(tmp_path: Path) -> None:
    require_different({"--csv": os.devnull, "--plot": os.devnull}, tmp_path / "x")
