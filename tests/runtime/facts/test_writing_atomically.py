"""Files that another process may read at any moment, also when their writer has been killed."""

from __future__ import annotations

import os
import stat
import sys
from pathlib import Path

import pytest

from rtgen.facts.files import write_atomically


@pytest.mark.parametrize("durable", [False, True])
def test_readers_get_all_of_the_old_or_of_the_new_content(
    tmp_path: Path, durable: bool
) -> None:
    file = tmp_path / "list"
    write_atomically(file, b"old", durable=durable)
    with file.open("rb") as reader:
        write_atomically(file, b"new", durable=durable)
        assert reader.read() == b"old"
    assert file.read_bytes() == b"new"
    assert [*tmp_path.iterdir()] == [file]


def test_what_a_killed_process_of_the_same_number_has_left_is_replaced(
    tmp_path: Path,
) -> None:
    rest, other = tmp_path / f".list.{os.getpid()}", tmp_path / "other"
    other.write_bytes(b"other")
    rest.symlink_to(other)
    write_atomically(tmp_path / "list", b"new", mode=0o600)
    assert other.read_bytes() == b"other"
    assert not rest.is_symlink()
    if sys.platform != "win32":
        assert stat.S_IMODE((tmp_path / "list").stat().st_mode) == 0o600


def test_a_failure_leaves_what_was_there(tmp_path: Path) -> None:
    folder = tmp_path / "folder"
    folder.mkdir()
    with pytest.raises(IsADirectoryError):
        write_atomically(folder, b"new")
    assert [*tmp_path.iterdir()] == [folder]
    with pytest.raises(FileNotFoundError):
        write_atomically(tmp_path / "none/list", b"new")
