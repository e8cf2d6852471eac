"""Copies the definition files of a git revision into a folder, without touching the checkout."""

from __future__ import annotations

import subprocess
from collections.abc import Sequence
from difflib import get_close_matches
from pathlib import Path, PurePosixPath

from rtgen.diagnostics import InputError, ToolError
from rtgen.diff.kinds.catalogue import GIT_FAILED, NO_VERSION, TOO_LARGE

MAX_FILES = 50_000
"""Maximum number of files copied from a revision."""

MAX_BYTES = 256 * 1024 * 1024
"""Maximum total size of these files."""

_MAX_FILE_BYTES = 32 * 1024 * 1024
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
    text = result.stdout.decode("utf-8", "surrogateescape").rstrip("\n")
    return Path(text).resolve() if result.returncode == 0 and text else None


def commit_of(repository: Path, revision: str) -> str | None:
    """Return the commit of a revision; None if it is unknown."""
    if revision.startswith("-") or "\0" in revision:
        return None
    name = f"{revision}^{{commit}}"
    result = _git(
        repository, "rev-parse", "--verify", "--quiet", "--end-of-options", name
    )
    text = result.stdout.decode("ascii", "replace").strip()
    return text.splitlines()[-1] if result.returncode == 0 and text else None


def unknown_revision(repository: Path | None, word: str) -> InputError:
    """Return the error for a word that is not a file, folder or revision."""
    message = f"{word!r} is not a file, folder or git revision"
    if repository is None:
        hint = "the working folder is in no git repository"
    else:
        result = _git(repository, "for-each-ref", "--format=%(refname:short)")
        names = result.stdout.decode("utf-8", "replace").splitlines()
        close = get_close_matches(word, names, n=1)
        hint = f"did you mean {close[0]}?" if close else "git log --all shows revisions"
    return InputError([NO_VERSION.at(None, message, hint=hint)])


def extract(repository: Path, commit: str, folder: Path) -> None:
    """Write the definition files of a commit below `folder`, without links.

    Raises InputError for a revision that git cannot read or that is too large.
    """
    listing = _git(repository, "ls-tree", "-r", "-z", "-l", "--full-tree", commit)
    if listing.returncode:
        raise _failed(listing)
    chosen: list[tuple[bytes, str, int]] = []
    for line in listing.stdout.split(b"\0"):
        head, tab, name = line.partition(b"\t")
        parts = head.split()
        if not tab or len(parts) != 4 or parts[0] not in _REGULAR:
            continue
        path = name.decode("utf-8", "surrogateescape")
        size = int(parts[3])
        if size <= _MAX_FILE_BYTES and _is_wanted(path):
            chosen.append((parts[2], path, size))
    total = sum(size for _, _, size in chosen)
    if len(chosen) > MAX_FILES or total > MAX_BYTES:
        message = (
            f"{commit[:12]} has {len(chosen)} files of {total} octets; "
            f"{MAX_FILES} files and {MAX_BYTES} octets are read"
        )
        raise InputError([TOO_LARGE.at(None, message, hint="give two folders instead")])
    wanted = b"".join(blob + b"\n" for blob, _, _ in chosen)
    content = _git(repository, "cat-file", "--batch", given=wanted)
    if content.returncode:
        raise _failed(content)
    _write(content.stdout, [path for _, path, _ in chosen], folder)


def _write(data: bytes, paths: Sequence[str], folder: Path) -> None:
    """Write the output of `git cat-file --batch` to files."""
    offset = 0
    for path in paths:
        end = data.index(b"\n", offset)
        size = int(data[offset:end].split()[-1])
        target = folder / path
        target.parent.mkdir(parents=True, exist_ok=True)
        target.write_bytes(data[end + 1 : end + 1 + size])
        offset = end + 1 + size + 1


def _is_wanted(path: str) -> bool:
    pure = PurePosixPath(path)
    inside = not pure.is_absolute() and ".." not in pure.parts
    return inside and pure.suffix.lower() not in _NO_DEFINITION


def _failed(result: subprocess.CompletedProcess[bytes]) -> InputError:
    text = result.stderr.decode("utf-8", "replace").strip() or "git failed"
    return InputError([GIT_FAILED.at(None, text.splitlines()[-1])])


def _git(
    folder: Path, *arguments: str, given: bytes = b""
) -> subprocess.CompletedProcess[bytes]:
    """Run git. Raises ToolError if it is missing or does not terminate."""
    try:
        return subprocess.run(
            ["git", "-C", str(folder), *arguments],
            input=given,
            capture_output=True,
            timeout=_TIMEOUT,
            check=False,
        )
    except FileNotFoundError as error:
        raise ToolError(
            "git is not installed, so revisions cannot be read",
            hint="install git, or compare two files or folders",
        ) from error
    except subprocess.TimeoutExpired as error:
        raise ToolError(f"git {arguments[0]} did not end in {_TIMEOUT:g} s") from error
