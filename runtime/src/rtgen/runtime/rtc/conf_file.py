"""`.conf` files of components: `key: value` lines as OpenRTM reads them."""

from __future__ import annotations

import math
import re
from pathlib import Path

import msgspec

from rtgen.facts.encodings import decode
from rtgen.facts.files import UnreadableError, read_file
from rtgen.facts.threads import Threads
from rtgen.runtime.errors import ConfFileError

_MAX_BYTES = 1024 * 1024

ACTIVE_SET = "configuration.active_config"
"""The key of the active configuration set."""

_ESCAPED = re.compile(r"\\(.?)", re.DOTALL)
_CONTROLS = {"t": "\t", "n": "\n", "r": "\r", "f": "\f"}
_LINE = re.compile(r"(?P<key>[^:=\s]+)\s*[:=](?P<value>.*)", re.DOTALL)


class ConfFile(msgspec.Struct, frozen=True, gc=False):
    """Content of a `.conf` file; `sets` maps set id to parameter to text, `lines` key to line.

    `others` has keys without meaning here, such as `logger.enable`, and sets whose names start with
    two underscores (`__widget__`, `__constraints__`, `__type__`), which are only for tools.
    """

    sets: dict[str, dict[str, str]] = msgspec.field(default_factory=dict)
    active_set: str | None = None
    rate: float | None = None
    threads: Threads | None = None
    others: dict[str, str] = msgspec.field(default_factory=dict)
    lines: dict[str, int] = msgspec.field(default_factory=dict)


def read(path: Path) -> ConfFile:
    """Read a file. Raises ConfFileError with file, line and reason."""
    try:
        text = decode(read_file(path, _MAX_BYTES), standard=True).normal
    except UnreadableError as error:
        raise ConfFileError(str(path), 0, str(error)) from error
    return parse(text, str(path))


def parse(text: str, name: str = "<conf>") -> ConfFile:
    """Parse the text of a `.conf` file; `name` is used in messages. Raises ConfFileError.

    `#` and `!` start comment lines, a trailing backslash joins the next line, the key ends at the
    first `:` or `=`; of a repeated key the last value is used. In keys and values, a backslash and
    one of `tnrf` are a control character; before another character, a backslash is removed.
    """
    conf = ConfFile()
    active_set, rate, threads = conf.active_set, conf.rate, conf.threads
    for number, line in _logical_lines(text):
        match = _LINE.fullmatch(line)
        if match is None:
            reason = "this is not of the form `key: value`"
            raise ConfFileError(name, number, reason)
        key, value = (_unescaped(match[part]).strip() for part in ("key", "value"))
        conf.lines[key] = number
        parts = key.split(".", 2)
        if parts[0] == "conf" and not key.startswith("conf.__"):
            if len(parts) < 3 or not all(parts):
                reason = f"{key!r} is not of the form conf.<set>.<parameter>"
                raise ConfFileError(name, number, reason)
            conf.sets.setdefault(parts[1], {})[parts[2]] = value
        elif key == ACTIVE_SET:
            active_set = value
        elif key == "exec_cxt.periodic.rate":
            rate = _rate(value, name, number)
        elif key == "rtgen.threads":
            threads = _threads(value, name, number)
        else:
            conf.others[key] = value
    return ConfFile(conf.sets, active_set, rate, threads, conf.others, conf.lines)


def _logical_lines(text: str) -> list[tuple[int, str]]:
    """Return the nonempty lines, joined at backslashes, with their first line numbers."""
    lines: list[tuple[int, str]] = []
    joined, start = "", 0
    for number, raw in enumerate(text.lstrip("\ufeff").splitlines(), 1):
        line = raw.strip()
        if not joined:
            start = number
            if not line or line.startswith(("#", "!")):
                continue
        if (len(line) - len(line.rstrip("\\"))) % 2:
            joined += line[:-1].rstrip()
            continue
        lines.append((start, joined + line))
        joined = ""
    if joined:
        lines.append((start, joined))
    return lines


def _unescaped(text: str) -> str:
    return _ESCAPED.sub(lambda match: _CONTROLS.get(match[1], match[1]), text)


def _threads(text: str, name: str, line: int) -> Threads:
    if text not in set(Threads):
        raise ConfFileError(name, line, f"{text!r} is not `shared` or `own`")
    return Threads(text)


def _rate(text: str, name: str, line: int) -> float:
    try:
        rate = float(text)
    except ValueError:
        rate = math.nan
    if not (math.isfinite(rate) and rate > 0.0):
        reason = f"the rate {text!r} must be a number of Hz above 0"
        raise ConfFileError(name, line, reason)
    return rate
