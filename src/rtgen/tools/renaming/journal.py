"""The journal of a rename: a process that is killed leaves it, and the next command completes it.

It is a file beside rtgen.toml with the old and the new content of each file. It is there from
before the first change until after the last one, and locked by the process that writes.
"""

from __future__ import annotations

import json
import os
from base64 import b64decode, b64encode
from collections.abc import Iterator, Mapping, Sequence
from contextlib import contextmanager, suppress
from dataclasses import dataclass, field
from pathlib import Path

from rtgen.compiler.kit.own_files import RENAME_JOURNAL
from rtgen.facts.files import read_file, replace_file, write_atomically

_MAX_BYTES = 256 * 1024 * 1024


@dataclass(slots=True)
class Outcome:
    """An interrupted rename that was completed; `left` are files that have changed since."""

    old: str
    new: str
    left: list[Path] = field(default_factory=list)


@contextmanager
def begin(
    root: Path,
    names: tuple[str, str],
    contents: Mapping[str, tuple[bytes, bytes]],
    moves: Sequence[tuple[Path, Path]],
) -> Iterator[None]:
    """Have a journal of a rename within the block. Raises OSError."""
    path = root / RENAME_JOURNAL
    entry = {
        "names": names,
        "contents": [
            [_relative(root, Path(name)), _text(old), _text(new)]
            for name, (old, new) in contents.items()
        ],
        "moves": [
            [
                _relative(root, source),
                _relative(root, target),
                _text(read_file(target)) if target.exists() else None,
            ]
            for source, target in moves
        ],
    }
    write_atomically(path, json.dumps(entry).encode(), mode=0o600, durable=True)
    try:
        with _locked(path):
            yield
    finally:
        path.unlink(missing_ok=True)


def complete(root: Path) -> Outcome | None:
    """Complete the rename whose journal is in a folder, and remove it.

    Return None if another process carries it out. Files outside the folder, or with another content
    than before and after the rename, are left. Raises OSError, ValueError for a damaged journal.
    """
    path = root / RENAME_JOURNAL
    with _locked(path) as is_free:
        if not is_free:
            return None
        try:
            entry = json.loads(read_file(path, _MAX_BYTES))
            old_name, new_name = entry["names"]
            outcome = Outcome(str(old_name), str(new_name))
            contents = [
                (root / n, _octets(o), _octets(w)) for n, o, w in entry["contents"]
            ]
            moves = [
                (root / s, root / t, k and _octets(k)) for s, t, k in entry["moves"]
            ]
        except (KeyError, TypeError, ValueError, RecursionError):
            raise ValueError(f"{path} is no journal of a rename") from None
        for file, old, new in contents:
            if not _is_inside(root, file) or not _replaced(file, old, new):
                outcome.left.append(file)
        for source, target, skeleton in moves:
            is_inside = _is_inside(root, source) and _is_inside(root, target)
            if not is_inside or not _moved(source, target, skeleton):
                outcome.left.append(source)
        path.unlink(missing_ok=True)
    return outcome


def _replaced(file: Path, old: bytes, new: bytes) -> bool:
    with suppress(OSError):
        now = read_file(file)
        if now == old:
            replace_file(file, new, old)
        return now in (old, new)
    return False


def _moved(source: Path, target: Path, skeleton: bytes | None) -> bool:
    """Move a file unless that is done; one in its way must be the skeleton of before."""
    if not source.exists():
        return target.exists()
    if target.exists() and read_file(target) != skeleton:
        return False
    source.replace(target)
    return True


def _is_inside(root: Path, file: Path) -> bool:
    return file.resolve().is_relative_to(root.resolve())


def _relative(root: Path, file: Path) -> str:
    return Path(os.path.relpath(file, root)).as_posix()


def _text(data: bytes) -> str:
    return b64encode(data).decode()


def _octets(text: str) -> bytes:
    return b64decode(text, validate=True)


@contextmanager
def _locked(path: Path) -> Iterator[bool]:
    """Lock a file within the block, and yield whether no other process has.

    Where there are no locks, none has.
    """
    try:
        import fcntl
    except ImportError:
        yield True
        return
    with path.open("rb") as stream:
        try:
            fcntl.flock(stream, fcntl.LOCK_EX | fcntl.LOCK_NB)
        except BlockingIOError:
            yield False
            return
        except OSError:
            pass  # Some network file systems have no locks.
        yield True
