"""Stored answers of commands: what they have printed, while nothing that they look at has changed.

An answer is valid for the same arguments, working folder, environment and rtgen, as long as each
look of the run at the disk would give the same. This module is imported before all others, so it
imports only what an answer from the cache needs; `answering` stores them.
"""

from __future__ import annotations

import os
import sys
import time
import zlib
from collections.abc import Sequence

from rtgen.compiler.kit.own_files import (
    PACKAGE,
    RUNS,
    compiler_folders,
    read_own,
    stamp,
    user_folder,
)
from rtgen.facts import looks
from rtgen.tools.kit.terminals import width_of

COMMANDS = frozenset({"check", "explain", "lint"})
"""The commands whose answers are stored."""

VARIABLES = (
    *("CI", "COLUMNS", "FORCE_COLOR", "GITHUB_WORKSPACE", "HOME", "NO_COLOR", "TERM"),
    *(
        "LANG",
        "LC_ALL",
        "LC_CTYPE",
        "LC_MESSAGES",
        "PYTHONIOENCODING",
        "PYTHONUTF8",
    ),
    *("PATH", "RTM_IDL", "RTM_ROOT", "TECSPATH", "_RTGEN_COMPLETE"),
)
"""The variables of the environment that can change an answer, besides `RTGEN_...`."""

MAX_BYTES = 8 * 1024 * 1024
"""Maximum size of an answer."""
_FORMAT = "rtgen-answer/1"
_PLACE = "RTGEN_CACHE_DIR"


def circumstances(arguments: Sequence[str]) -> list[str]:
    """Return what decides the file of an answer: how the command is called, and where."""
    own = sorted(n for n in os.environ if n.startswith("RTGEN_") and n != _PLACE)
    streams = (sys.stdout, sys.stderr)
    return [
        _FORMAT,
        *arguments,
        "",
        os.getcwd(),
        *(f"{name}={os.environ.get(name)}" for name in (*VARIABLES, *own)),
        *(
            f"{each.isatty()} {width_of(each)} {each.encoding} {each.errors}"
            for each in streams
        ),
        sys.version,
        sys.executable,
        *sys.path,
    ]


def program() -> str:
    """Return the stamp of rtgen."""
    parts = (os.path.join(PACKAGE, name) for name in ("cli", "locale", "tools"))
    return stamp([*compiler_folders(), *filter(os.path.isdir, parts)])


def name_of(called: Sequence[str]) -> str:
    """Return the name of the file of an answer."""
    return f"{zlib.crc32(_octets(called)):08x}.answer"


def in_full(called: Sequence[str]) -> bytes:
    """Return the circumstances with the stamp of rtgen."""
    return _octets([*called, program()])


class Answer:
    """What a command has printed, and what that depends on.

    `circumstances` are those of the call, with the stamp of rtgen; `seen` has looks with their
    status and digest, `output` texts on standard error and octets on standard output.
    """

    __slots__ = ("circumstances", "code", "output", "seen")

    def __init__(
        self,
        circumstances: bytes,
        seen: Sequence[tuple[str, str, str]],
        output: Sequence[str | bytes],
        code: int,
    ) -> None:
        self.circumstances = circumstances
        self.seen = seen
        self.output = output
        self.code = code

    def packed(self) -> bytes:
        """Return the content of the file."""
        parts = [
            self.circumstances,
            *(_octets(look) for look in self.seen),
            b"",
            *(
                (
                    b"e" + part.encode("utf-8", "surrogatepass")
                    if isinstance(part, str)
                    else b"o" + part
                )
                for part in self.output
            ),
        ]
        head = f"{self.code} {' '.join(str(len(part)) for part in parts)}\n".encode()
        body = head + b"".join(parts)
        return b"%08x\n" % zlib.crc32(body) + body

    @classmethod
    def unpacked(cls, data: bytes) -> Answer:
        """Return the answer in a file. Raises ValueError for damaged ones."""
        check, _, body = data.partition(b"\n")
        if check != b"%08x" % zlib.crc32(body):
            raise ValueError("damaged")
        head, _, rest = body.partition(b"\n")
        code, *sizes = map(int, head.split())
        parts = []
        end = 0
        for size in sizes:
            begin, end = end, end + size
            parts.append(rest[begin:end])
        last = parts.index(b"")
        seen = [_look(part) for part in parts[1:last]]
        output = [
            part[1:].decode("utf-8", "surrogatepass") if part[:1] == b"e" else part[1:]
            for part in parts[last + 1 :]
        ]
        return cls(parts[0], seen, output, code)


def repeat(arguments: Sequence[str]) -> int | None:
    """Print the stored answer to a command line, and return its exit code; None without one."""
    if not arguments or arguments[0] not in COMMANDS:
        return None
    try:
        called = circumstances(arguments)
        file = os.path.join(user_folder(), RUNS, name_of(called))
        data = read_own(file, MAX_BYTES)
        if data is None:
            return None
        answer = Answer.unpacked(data)
        if answer.circumstances != in_full(called) or not _is_valid(answer, file):
            return None
        for part in answer.output:
            _write(part)
    except (OSError, ValueError):
        return None  # the command meets it, too, and reports it
    return answer.code


def _is_valid(answer: Answer, file: str) -> bool:
    """Return whether all looks would give the same; their status is stored if it is another."""
    seen = []
    for name, before, digest in answer.seen:
        now = looks.status(name)
        if now != before and not looks.is_same(name, now, before, digest):
            return False
        seen.append((name, now, digest))
    if seen == answer.seen:
        os.utime(file)  # files of the cache that are used stay
    elif all(looks.is_settled(now, time.time_ns()) for _, now, _ in seen):
        from pathlib import Path

        from rtgen.facts.files import write_atomically

        answer.seen = seen
        write_atomically(Path(file), answer.packed(), mode=0o600)
    return True


def _octets(texts: Sequence[str]) -> bytes:
    return os.fsencode("\0".join(texts))


def _texts(octets: bytes) -> list[str]:
    return os.fsdecode(octets).split("\0")


def _look(octets: bytes) -> tuple[str, str, str]:
    name, status, digest = _texts(octets)
    return name, status, digest


def _write(part: str | bytes) -> None:
    """Write a part of the output as `console` does."""
    if isinstance(part, str):
        sys.stderr.write(part)
        return
    try:
        sys.stdout.flush()
        sys.stdout.buffer.write(part)
        sys.stdout.buffer.flush()
    except BrokenPipeError:
        from rtgen.tools.kit.console import discard_unread

        discard_unread()
