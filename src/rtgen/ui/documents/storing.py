"""Writes the file of a system; what another writer has put there is not replaced unasked."""

from __future__ import annotations

from itertools import count
from pathlib import Path

from rtgen.facts import files


class OtherContentError(Exception):
    """The file has content that the user has not seen; the message says why."""


def store(
    path: Path, data: bytes, known: bytes | None, *, replace: bool = False
) -> Path | None:
    """Write a file whole, or leave it as it is.

    `known` is the content that the user has seen; None if the file should not exist. With
    `replace`, other content is kept in a file beside it, whose path is returned. Raises
    OtherContentError without `replace`, and OSError.
    """
    content = _content(path)
    if content is None:
        _create(path, data)
        return None
    backup = None
    if content not in (known, data):
        if not replace:
            raise OtherContentError(
                "it exists already" if known is None else "it has changed on the disk"
            )
        backup = _write_backup(path, content)
    files.replace_file(path, data, content)
    return backup


def _content(path: Path) -> bytes | None:
    """Return the content of a file; None without one."""
    if not path.is_symlink() and not path.exists():
        return None
    return files.read_file(path)


def _create(path: Path, data: bytes) -> None:
    """Write a new file whole, or none. Raises OSError, FileExistsError if there is one."""
    with path.open("xb") as stream:
        try:
            stream.write(data)
            stream.flush()
        except OSError:
            path.unlink()
            raise


def _write_backup(path: Path, data: bytes) -> Path:
    """Write a file of a new name beside another one."""
    names = (f"{path.name}~" if n == 1 else f"{path.name}.~{n}~" for n in count(1))
    for name in names:
        backup = path.with_name(name)
        try:
            _create(backup, data)
        except FileExistsError:
            continue
        return backup
    raise AssertionError  # `names` does not end.
