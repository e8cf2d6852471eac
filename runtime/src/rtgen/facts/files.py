"""Files of the user: bounded reading of regular files, and replacement of their content.

An editor's unsaved texts take precedence over the files on the disk. Pipes, devices, sockets and
folders are refused without being opened: opening one can block, and reading one need not end.
"""

from __future__ import annotations

import contextlib
import errno
import os
import stat
import sys
from collections.abc import Collection, Iterator, Mapping
from contextlib import contextmanager
from contextvars import ContextVar
from pathlib import Path
from typing import BinaryIO

from rtgen.facts.looks import CONTENT, KIND, LINK, NAMES, look

_OVERLAY: ContextVar[Mapping[str, bytes] | None] = ContextVar("overlay", default=None)
_READING = os.O_RDONLY | getattr(os, "O_NONBLOCK", 0) | getattr(os, "O_BINARY", 0)
_WRITING = (
    os.O_RDWR
    | os.O_CREAT
    | getattr(os, "O_NOFOLLOW", 0)
    | getattr(os, "O_NONBLOCK", 0)
    | getattr(os, "O_BINARY", 0)
)
_PIECE = 1 << 16
_NULL = "a path has no null character"
_KINDS = (
    (stat.S_ISDIR, "folder"),
    (stat.S_ISFIFO, "pipe"),
    (stat.S_ISSOCK, "socket"),
    (stat.S_ISCHR, "device"),
    (stat.S_ISBLK, "device"),
)


MAX_BYTES = 32 * 1024 * 1024
"""Maximum size of a file that is read as a whole, where its format has no smaller one."""


class UnreadableError(OSError):
    """A file that cannot be read, or is too large; the message says why."""

    def __init__(self, reason: str) -> None:
        super().__init__(errno.EINVAL, reason)

    def __str__(self) -> str:
        return str(self.strerror)


class ChangedError(OSError):
    """A file whose content is not the one that is to be replaced; it is left as it is."""

    def __init__(self) -> None:
        super().__init__(errno.EBUSY, "it has been changed meanwhile")


def absolute_path(path: Path | str) -> str:
    """Return the absolute path without `..`. Links are kept: a file's includes are relative to
    it.
    """
    return os.path.normpath(Path.cwd() / path)


def real_path(path: str) -> str:
    """Return a path without links; one that no file has is returned as it is."""
    return path if "\0" in path else os.path.realpath(path)


@contextmanager
def overlaid(contents: Mapping[str, bytes]) -> Iterator[None]:
    """Within the block, `contents` by absolute path replace what is on the disk."""
    token = _OVERLAY.set(contents)
    try:
        yield
    finally:
        _OVERLAY.reset(token)


def is_file(path: Path) -> bool:
    """Return whether the path is a regular file, or a link to one. Raises OSError for a path that
    the file system cannot have.
    """
    look(KIND, path)
    return _unsaved(path) is not None or path.is_file()


def is_folder(path: Path) -> bool:
    """Return whether the path is a folder, or a link to one."""
    look(KIND, path)
    return path.is_dir()


def exists(path: Path, *, as_link: bool = False) -> bool:
    """Return whether anything is at the path; `as_link`: a link without a target counts."""
    look(LINK if as_link else KIND, path)
    return os.path.lexists(path) if as_link else path.exists()


def modules_in(folder: Path) -> list[Path]:
    """Return the paths of Python modules in a folder, sorted."""
    look(NAMES, folder)
    return sorted(folder.glob("*.py"))


def in_order(folder: Path) -> list[Path]:
    """Return the paths in a folder, sorted. Raises OSError."""
    look(NAMES, folder)
    return sorted(folder.iterdir())


def walk(folder: Path) -> Iterator[tuple[str, list[str], list[str]]]:
    """Yield what `os.walk` does."""
    look(NAMES, folder)  # for one that is missing
    for each in os.walk(folder):
        look(NAMES, each[0])
        yield each


def in_folder(folder: Path, suffixes: Collection[str]) -> list[Path]:
    """Return the paths in a folder that have one of the suffixes, in either case, in order."""
    look(NAMES, folder)
    return [
        path for path in sorted(folder.glob("*")) if path.suffix.lower() in suffixes
    ]


def open_file(path: Path) -> BinaryIO:
    """Open a regular file on the disk for reading. Raises OSError, whose `strerror` says why."""
    look(CONTENT, path)
    try:
        # A device is not even opened: a watchdog would start, a serial line would reset its peer.
        _require_regular(path.stat())
        number = os.open(path, _READING)
    except ValueError as error:
        # Python's versions word it differently.
        reason = _NULL if "\0" in str(path) else str(error)
        raise UnreadableError(reason) from None
    try:
        _require_regular(os.fstat(number))
    except BaseException:
        os.close(number)
        raise
    return os.fdopen(number, "rb")


def check_file(path: Path, limit: int = MAX_BYTES) -> None:
    """Check a file that something else opens by name. Raises UnreadableError, as `read_file`."""
    try:
        with open_file(path) as stream:
            size = os.fstat(stream.fileno()).st_size
    except OSError as error:
        raise UnreadableError(error.strerror or str(error)) from None
    if size > limit:
        raise _too_large(limit)


def read_start(path: Path, limit: int) -> bytes:
    """Return up to `limit` bytes from the start of a file. Raises OSError, as `open_file`."""
    data = _unsaved(path)
    if data is not None:
        return data if len(data) <= limit else data[:limit]
    with open_file(path) as stream:
        # As many octets as there are: `read` allocates what is requested.
        most = max(os.fstat(stream.fileno()).st_size, _PIECE)
        parts = []
        while limit > 0 and (part := stream.read(min(limit, most))):
            parts.append(part)
            limit -= len(part)
        return b"".join(parts)


def read_file(path: Path, limit: int = MAX_BYTES) -> bytes:
    """Return the bytes of a file. Raises UnreadableError, also if there are more than `limit`."""
    try:
        data = read_start(path, limit + 1)
    except OSError as error:
        raise UnreadableError(error.strerror or str(error)) from None
    if len(data) > limit:
        raise _too_large(limit)
    return data


def create_file(path: Path) -> BinaryIO:
    """Open a file for writing, created or emptied, in a folder made if missing. Raises OSError.

    A device is opened, and a pipe that something reads; without a reader, opening would wait.
    """
    check_output(path)
    make_folder(path.parent)
    flags = os.O_WRONLY | os.O_CREAT | os.O_TRUNC | getattr(os, "O_BINARY", 0)
    try:
        number = os.open(path, flags | getattr(os, "O_NONBLOCK", 0), 0o666)
    except OSError as error:
        if error.errno == errno.ENXIO and path.is_fifo():
            raise UnreadableError("nothing reads this pipe") from None
        raise
    if hasattr(os, "O_NONBLOCK"):
        os.set_blocking(number, True)
    return os.fdopen(number, "wb")


def make_folder(path: Path) -> None:
    """Make a folder and those around it, unless they exist. Raises OSError."""
    try:
        path.mkdir(parents=True, exist_ok=True)
    except FileExistsError:
        raise NotADirectoryError(
            errno.ENOTDIR, os.strerror(errno.ENOTDIR), str(path)
        ) from None


def write_atomically(
    path: Path, data: bytes, *, mode: int = 0o666, durable: bool = False
) -> None:
    """Create or replace a file at once: who reads it gets all of the old or of the new content.

    That holds when the process is killed too, and with `durable` after a loss of power. Raises
    OSError; the file is then as before. `replace_file` is for files of users.
    """
    temporary = path.with_name(f".{path.name}.{os.getpid()}")
    temporary.unlink(missing_ok=True)
    flags = os.O_WRONLY | os.O_CREAT | os.O_EXCL | getattr(os, "O_BINARY", 0)
    try:
        with os.fdopen(os.open(temporary, flags, mode), "wb") as stream:
            stream.write(data)
            if durable:
                stream.flush()
                os.fsync(stream.fileno())
        temporary.replace(path)
    except BaseException:
        temporary.unlink(missing_ok=True)
        raise


def check_output(path: Path, *, pipes: bool = True) -> None:
    """Check a file that is to be written, by something else if `pipes` is false. Raises OSError."""
    if "\0" in str(path):
        raise UnreadableError(_NULL)
    with contextlib.suppress(FileNotFoundError):
        mode = path.stat().st_mode
        if stat.S_ISSOCK(mode) or (stat.S_ISFIFO(mode) and not pipes):
            _require_regular(path.stat())


def replace_file(path: Path, data: bytes, before: bytes) -> None:
    """Replace the content `before` of a file, or of a link's target, by `data`.

    The replacement is atomic, and permissions are kept. A file with further hard links, or of
    another user, is written in place. Raises ChangedError if the file has another content, else
    OSError; the file is then as before.
    """
    import shutil

    _require_regular(path.stat())
    target = path.resolve()
    if not os.access(target, os.W_OK):
        raise PermissionError(errno.EACCES, os.strerror(errno.EACCES), str(path))
    with _temporary_beside(target) as temporary:
        with temporary.open("wb") as stream:
            stream.write(data)
            stream.flush()
            os.fsync(stream.fileno())
        shutil.copystat(target, temporary)
        os.utime(temporary)
        with open_file(target) as stream:
            if stream.read(len(before) + 1) != before:
                raise ChangedError
            old = os.fstat(stream.fileno())
        new = temporary.stat()
        if (old.st_nlink, old.st_uid, old.st_gid) == (1, new.st_uid, new.st_gid):
            temporary.replace(target)
        else:
            _overwrite(target, data, before)


def _require_regular(status: os.stat_result) -> None:
    if not stat.S_ISREG(status.st_mode):
        kind = next((name for is_, name in _KINDS if is_(status.st_mode)), "thing")
        raise UnreadableError(f"it is a {kind}, not a file")


def _too_large(limit: int) -> UnreadableError:
    return UnreadableError(f"it is larger than {limit:,} bytes")


def _unsaved(path: Path) -> bytes | None:
    contents = _OVERLAY.get()
    return contents.get(absolute_path(path)) if contents else None


@contextmanager
def _temporary_beside(target: Path) -> Iterator[Path]:
    """Yield an empty file in the folder of `target`; it is removed at the end, if still there.

    Its name is the same in each run, so that what a killed one has left is used by the next one.
    """
    from hashlib import sha256

    digest = sha256(os.fsencode(target.name)).hexdigest()[:16]
    temporary = target.with_name(f".rtgen-{digest}.part")
    if (
        sys.platform == "win32"
    ):  # an open file can be neither removed nor replaced there
        temporary.unlink(missing_ok=True)
        temporary.touch(exist_ok=False)
        try:
            yield temporary
        finally:
            temporary.unlink(missing_ok=True)
        return
    number = _locked(temporary)
    try:
        yield temporary
    finally:
        if _is_at(number, temporary):
            temporary.unlink()
        os.close(number)


def _locked(temporary: Path) -> int:
    """Return the descriptor of a file that only this run writes; the lock ends with its process."""
    import fcntl

    while True:
        number = os.open(temporary, _WRITING, 0o600)
        try:
            try:
                fcntl.flock(number, fcntl.LOCK_EX | fcntl.LOCK_NB)
            except BlockingIOError:
                message = "another run of rtgen is writing it"
                raise OSError(errno.EBUSY, message) from None
            except OSError:
                pass  # Some network file systems have no locks: concurrent runs are not prevented.
            # Another run may have moved the file to its target before the lock.
            if _is_at(number, temporary):
                found = os.fstat(number)
                _require_regular(found)
                if found.st_nlink > 1:
                    raise OSError(errno.EMLINK, os.strerror(errno.EMLINK))
                return number
        except BaseException:
            os.close(number)
            raise
        os.close(number)


def _is_at(number: int, path: Path) -> bool:
    try:
        return os.path.samestat(os.fstat(number), path.lstat())
    except FileNotFoundError:
        return False


def _overwrite(target: Path, data: bytes, before: bytes) -> None:
    """Write a file in place; after an error its content is `before`."""
    number = os.open(target, os.O_WRONLY | getattr(os, "O_BINARY", 0))
    try:
        _write_all(number, data)
    except OSError:
        with contextlib.suppress(OSError):
            _write_all(number, before)
        raise
    finally:
        os.close(number)


def _write_all(number: int, data: bytes) -> None:
    rest = memoryview(data)
    os.lseek(number, 0, os.SEEK_SET)
    while rest:
        rest = rest[os.write(number, rest) :]
    os.ftruncate(number, len(data))
