"""Copies the definition files of a git revision into a folder, without touching the checkout."""

from __future__ import annotations

import subprocess
import threading
from collections.abc import Iterator, Sequence
from difflib import get_close_matches
from pathlib import Path, PurePosixPath
from tempfile import TemporaryFile
from typing import NamedTuple

from rtgen.compiler.diagnostics import InputError, ToolError
from rtgen.tools.diff.kinds.catalogue import GIT_FAILED, NO_VERSION, TOO_LARGE

MAX_FILES = 50_000
"""Maximum number of files copied from a revision."""

MAX_BYTES = 256 * 1024 * 1024
"""Maximum total size of these files."""

_MAX_FILE_BYTES = 32 * 1024 * 1024
_MAX_LISTING = 16 * 1024 * 1024
"""Maximum octets of a list of git; a tree that refers to itself in many places has no end."""
_MAX_HEADER = 128
"""Maximum octets of git around the content of a file."""
_MAX_MESSAGE = 4096
_REMOTE_HEAD = "refs/remotes/origin/HEAD"
_SHOWN = 100
"""Maximum characters of a path in a message."""
_TIMEOUT = 120.0
_REGULAR = (b"100644", b"100755")
_NO_DEFINITION = frozenset(
    (
        *(".py", ".pyc", ".md", ".png", ".jpg", ".jpeg", ".gif", ".svg", ".pdf"),
        *(".zip", ".gz", ".xz", ".whl", ".so", ".bin", ".mcap", ".parquet", ".mp4"),
    )
)


def top_level(folder: Path) -> Path | None:
    """Return the root of the repository around a folder; None outside of one."""
    result = _git(folder, "rev-parse", "--show-toplevel")
    text = result.output.decode("utf-8", "surrogateescape").rstrip("\n")
    return Path(text).resolve() if result.code == 0 and text else None


def commit_of(repository: Path, revision: str) -> str | None:
    """Return the commit of a revision; None if it is unknown."""
    if revision.startswith("-") or "\0" in revision:
        return None
    name = f"{revision}^{{commit}}"
    result = _git(
        repository, "rev-parse", "--verify", "--quiet", "--end-of-options", name
    )
    text = result.output.decode("ascii", "replace").strip()
    return text.splitlines()[-1] if result.code == 0 and text else None


def main_branch(repository: Path) -> str | None:
    """Return the branch that others build on: that of the remote `origin`, else main or master."""
    head = _git(repository, "symbolic-ref", "--quiet", "--short", _REMOTE_HEAD)
    name = head.output.decode("utf-8", "surrogateescape").strip()
    names = [name] if head.code == 0 and name else []
    names += ["origin/main", "origin/master", "main", "master"]
    return next((each for each in names if commit_of(repository, each)), None)


def unknown_revision(repository: Path | None, word: str) -> InputError:
    """Return the error for a word that is not a file, folder or revision."""
    message = f"{word!r} is not a file, folder or git revision"
    if repository is None:
        hint = "the working folder is in no git repository"
    else:
        result = _git(repository, "for-each-ref", "--format=%(refname:short)")
        names = result.output.decode("utf-8", "replace").splitlines()
        close = get_close_matches(word, names, n=1)
        hint = f"did you mean {close[0]}?" if close else "git log --all shows revisions"
    return InputError([NO_VERSION.at(None, message, hint=hint)])


def extract(repository: Path, commit: str, folder: Path) -> None:
    """Write the definition files of a commit below `folder`, without links.

    Raises InputError for a revision that git cannot read, that is too large, or has files that
    cannot be written.
    """
    listing = _git(repository, "ls-tree", "-r", "-z", "-l", "--full-tree", commit)
    if listing.cut:
        raise _too_large(commit, f"more than {MAX_FILES} files")
    if listing.code:
        raise _failed(listing.message)
    chosen = [*_chosen(listing.output)]
    total = sum(each.size for each in chosen)
    if len(chosen) > MAX_FILES or total > MAX_BYTES:
        raise _too_large(commit, f"{len(chosen)} files of {total} octets")
    wanted = b"".join(each.blob + b"\n" for each in chosen)
    most = total + _MAX_HEADER * len(chosen)
    content = _git(repository, "cat-file", "--batch", given=wanted, most=most)
    if content.code:
        raise _failed(content.message)
    _write(content.output, chosen, folder)


class _File(NamedTuple):
    """A file of a tree: the name of its content, its path and its size."""

    blob: bytes
    path: str
    size: int


def _chosen(listing: bytes) -> Iterator[_File]:
    """Yield the files that could be definitions, by the output of `git ls-tree`."""
    for line in listing.split(b"\0"):
        head, tab, name = line.partition(b"\t")
        parts = head.split()
        if not tab or len(parts) != 4 or parts[0] not in _REGULAR:
            continue
        path = name.decode("utf-8", "surrogateescape")
        if PurePosixPath(path).suffix.lower() in _NO_DEFINITION:
            continue
        if not parts[3].isdigit():
            raise _failed(f"the content of {_short(path)} is missing")
        size = int(parts[3])
        if size <= _MAX_FILE_BYTES:
            yield _File(parts[2], path, size)


def _write(data: bytes, files: Sequence[_File], folder: Path) -> None:
    """Write the output of `git cat-file --batch` to files."""
    offset = 0
    for each in files:
        end = data.find(b"\n", offset)
        if data[offset:end].split() != [each.blob, b"blob", b"%d" % each.size]:
            raise _failed(f"the content of {_short(each.path)} is missing or damaged")
        offset = end + 1 + each.size + 1
        _create(folder, each.path, data[end + 1 : offset - 1])


def _create(folder: Path, path: str, content: bytes) -> None:
    """Write a file of a tree, which can have any names. Raises InputError."""
    message = f"the file {_short(path)} cannot be written"
    parts = path.split("/")
    if not {"", ".", ".."}.isdisjoint(parts):
        raise _failed(f"{message}: no folder is called so")
    target = folder.joinpath(*parts)
    try:
        target.parent.mkdir(parents=True, exist_ok=True)
        with target.open("xb") as stream:
            stream.write(content)
    except (OSError, ValueError) as error:
        reason = getattr(error, "strerror", None) or error
        raise _failed(f"{message}: {reason}") from None


def _short(path: str) -> str:
    return repr(path if len(path) <= _SHOWN else f"...{path[-_SHOWN:]}")


def _too_large(commit: str, what: str) -> InputError:
    message = (
        f"{commit[:12]} has {what}; {MAX_FILES} files and {MAX_BYTES} octets are read"
    )
    return InputError([TOO_LARGE.at(None, message, hint="give two folders instead")])


def _failed(message: str) -> InputError:
    return InputError([GIT_FAILED.at(None, message)])


class _Answer(NamedTuple):
    """What git has printed; `cut`: it was more than the limit, and git was stopped."""

    code: int
    output: bytes
    message: str
    cut: bool


def _git(
    folder: Path, *arguments: str, given: bytes = b"", most: int = _MAX_LISTING
) -> _Answer:
    """Run git, and return up to `most` octets of its output.

    Raises ToolError if it is missing or does not terminate.
    """
    with TemporaryFile() as request, TemporaryFile() as errors:
        request.write(given)
        request.seek(0)
        try:
            process = subprocess.Popen(
                ["git", "-C", str(folder), *arguments],
                stdin=request,
                stdout=subprocess.PIPE,
                stderr=errors,
            )
        except FileNotFoundError as error:
            raise ToolError(
                "git is not installed, so revisions cannot be read",
                hint="install git, or compare two files or folders",
            ) from error
        late = threading.Event()

        def stop() -> None:
            late.set()
            process.kill()

        timer = threading.Timer(_TIMEOUT, stop)
        timer.start()
        with process:
            try:
                assert process.stdout is not None
                output = process.stdout.read(most + 1)
                if len(output) > most:
                    process.kill()
                code = process.wait()
            except BaseException:
                process.kill()
                raise
            finally:
                timer.cancel()
        if late.is_set():
            raise ToolError(f"git {arguments[0]} did not end in {_TIMEOUT:g} s")
        errors.seek(0)
        text = errors.read(_MAX_MESSAGE).decode("utf-8", "replace").strip()
        message = (text or "git failed").splitlines()[-1]
        return _Answer(code, output, message, cut=len(output) > most)
