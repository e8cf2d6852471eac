"""The tokens of a port are stored for the next start, readable by the same user alone."""

from __future__ import annotations

import os
import time
from pathlib import Path

import pytest

from rtgen.ui.stored_tokens import MAX_AGE, tokens_of

PORT = 40123


@pytest.fixture
def file(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    monkeypatch.setenv("RTGEN_CACHE_DIR", str(tmp_path))
    return tmp_path / "ui" / f"{PORT}.tokens"


def test_they_are_those_of_the_last_start(file: Path) -> None:
    first = tokens_of(PORT)
    assert file.stat().st_mode & 0o777 == 0o600
    assert tokens_of(PORT) == first
    assert tokens_of(PORT + 1) != first
    assert sorted(each.name for each in file.parent.iterdir()) == [
        f"{PORT}.tokens",
        f"{PORT + 1}.tokens",
    ]


def test_after_a_day_they_are_new(file: Path) -> None:
    first = tokens_of(PORT)
    os.utime(file, (time.time() - MAX_AGE - 1,) * 2)
    assert tokens_of(PORT) != first


@pytest.mark.skipif(not hasattr(os, "getuid"), reason="files have no modes here")
def test_a_file_that_others_can_read_is_not_taken(file: Path) -> None:
    first = tokens_of(PORT)
    file.chmod(0o640)
    second = tokens_of(PORT)
    assert second != first
    elsewhere = file.with_name("elsewhere")
    file.rename(elsewhere)
    file.symlink_to(elsewhere)
    assert tokens_of(PORT) != second
    assert not file.is_symlink()


@pytest.mark.parametrize("text", ["", "one", "same same", " \0", "\u00e9"])
def test_what_is_no_pair_of_tokens_is_not_taken(file: Path, text: str) -> None:
    tokens_of(PORT)
    file.write_text(text)
    found = tokens_of(PORT)
    assert len(found.full) > 30
    assert found.full != found.read_only


def test_without_a_folder_they_are_new(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    (tmp_path / "file").touch()
    monkeypatch.setenv("RTGEN_CACHE_DIR", str(tmp_path / "file"))
    assert tokens_of(PORT) != tokens_of(PORT)
