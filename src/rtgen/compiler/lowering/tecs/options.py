"""The options in the argument of `RTCPlugin`: one table, and their check."""

from __future__ import annotations

import codecs
import math
import re
from collections.abc import Callable, Iterator
from dataclasses import dataclass, field, fields
from typing import Any

from rtgen.compiler.diagnostics import Diagnostic
from rtgen.compiler.kit.words import words
from rtgen.compiler.lowering.tecs.rules import BAD_OPTION, UNKNOWN_OPTION
from rtgen.compiler.model.tecs import PluginOption, Through
from rtgen.compiler.typemap.tecs.idl import Widths
from rtgen.facts.opaque_rpc import MAX_TIMEOUT, TIMEOUT

TECSGEN_OPTIONS = words("""
    TDRCelltype clientChannelCell clientChannelCelltype clientChannelInitializer clientErrorHandler
    clientSemaphoreCelltype clientSemaphoreInitializer noClientSemaphore noServerChannelOpenerCode
    serverChannelCell serverChannelCelltype serverChannelInitializer serverErrorHandler silent
    stackSize substituteAllocator taskCelltype taskPriority
    """)
"""Options of tecsgen's OpaqueRPCPlugin, for the board's half: they pass through `RTCPlugin.rb`."""

_UNITS = (16, 32, 64)
_PORT = re.compile(r"(\d{1,9})(?:\s*\+\s*(\d{1,9}))?")
_IDENTIFIER = re.compile(r"[A-Za-z_]\w*", re.ASCII)
_SAMPLE = "az09"


class _RefusalError(Exception):
    """An invalid value; the message states the valid ones."""


def _one_of(*words: str) -> Callable[[str], str]:
    def parse(text: str) -> str:
        if text not in words:
            raise _RefusalError(f"it is one of {', '.join(words)}")
        return text

    return parse


def _bits(text: str) -> int:
    if text not in map(str, _UNITS):
        raise _RefusalError("it is 16, 32 or 64")
    return int(text)


def _port(text: str) -> int:
    match = _PORT.fullmatch(text)
    port = sum(int(number) for number in match.groups("0")) if match else 0
    if not 1 <= port <= 65535:
        raise _RefusalError("it is a number from 1 to 65535")
    return port


def _count(text: str) -> int:
    if not re.fullmatch(r"[0-9]{1,9}", text) or int(text) == 0:
        raise _RefusalError("it is a whole number above 0")
    return int(text)


def _seconds(text: str) -> float:
    try:
        value = float(text if "_" not in text else "")
    except ValueError:
        value = math.nan
    if value > MAX_TIMEOUT:
        raise _RefusalError(f"it is at most {MAX_TIMEOUT:.0f} seconds")
    if not value > 0.0:
        raise _RefusalError("it is a number of seconds above 0")
    return value


def _text(text: str) -> str:
    if not text.strip() or not text.isprintable() or "," in text:
        raise _RefusalError("it is a text on one line, without commas")
    if text.rstrip().endswith("\\"):
        raise _RefusalError("it does not end in a backslash")
    return text.strip()


def _identifier(text: str) -> str:
    if not _IDENTIFIER.fullmatch(text):
        raise _RefusalError("it is a name: letters, digits and underscores")
    return text


def _encoding(text: str) -> str:
    """Return an encoding in which ASCII letters are single bytes, so that a NUL ends a text."""
    try:
        codecs.lookup(text)
        fits = _SAMPLE.encode(text) == _SAMPLE.encode("ascii")
    except (LookupError, UnicodeError, TypeError):
        fits = False
    if not fits:
        raise _RefusalError("it is an encoding that Python has and ASCII is part of")
    return text


def _option(
    name: str, parse: Callable[[str], object], default: object, shared: str = ""
) -> Any:
    return field(
        default=default,
        metadata={"name": name, "parse": parse, "shared": shared},
    )


@dataclass(frozen=True, slots=True)
class RtcOptions:
    """The options of an `RTCPlugin`; None if the default depends on other values.

    `shared` marks a field on which all joins of a signature, or of a file, must agree.
    """

    tdr: str = _option("tdr", _one_of("network", "little", "big"), "network", "file")
    reply: str = _option("reply", _one_of("tecsgen", "paper"), "tecsgen", "signature")
    long_bits: int | None = _option("longBits", _bits, None, "file")
    short_bits: int = _option("shortBits", _bits, 16, "file")
    int_bits: int = _option("intBits", _bits, 32, "file")
    intptr_bits: int | None = _option("intptrBits", _bits, None, "file")
    array: str = _option("array", _one_of("sequence", "any"), "sequence", "signature")
    encoding: str = _option("encoding", _encoding, "latin-1", "signature")
    limit: int = _option("PPAllocatorSize", _count, 4096, "signature")
    address: str = _option("address", _text, "127.0.0.1")
    port: int | None = _option("port", _port, None)
    device: str = _option("device", _text, "")
    baudrate: int = _option("baudrate", _count, 115200)
    timeout: float = _option("timeout", _seconds, TIMEOUT)
    name: str = _option("name", _identifier, "")

    @property
    def widths(self) -> Widths:
        """The widths of C's types; by default those of a 64-bit machine for `tTDR`."""
        usual = 32 if self.tdr == "network" else 64
        return Widths(
            self.short_bits,
            self.int_bits,
            self.long_bits or usual,
            self.intptr_bits or usual,
        )

    def differing(self, other: RtcOptions, *shared: str) -> list[str]:
        """Return the options, shared in one of these scopes, that differ from the other's."""
        if self == other:
            return []
        return [
            each.metadata["name"]
            for each in fields(self)
            if each.metadata["shared"] in shared
            and getattr(self, each.name) != getattr(other, each.name)
        ]


_FIELDS = {each.metadata["name"]: each for each in fields(RtcOptions)}

PC_OPTIONS = tuple(name for name in _FIELDS if name != "PPAllocatorSize")
"""The options that tecsgen's OpaqueRPCPlugin does not have."""

_NETWORK = RtcOptions().widths
NETWORK_WIDTHS = {
    "shortBits": _NETWORK.short,
    "intBits": _NETWORK.int_,
    "longBits": _NETWORK.long,
    "intptrBits": _NETWORK.intptr,
}
"""The widths of C's types on tecsgen's boards in the network's order."""


def read_options(through: Through) -> tuple[RtcOptions, list[Diagnostic]]:
    """Return the options of a plug-in, and diagnostics."""
    values: dict[str, object] = {}
    findings = list(_read(through.options, values))
    return RtcOptions(**values), findings  # type: ignore[arg-type]


def _read(
    options: tuple[PluginOption, ...], values: dict[str, object]
) -> Iterator[Diagnostic]:
    for option in options:
        field = _FIELDS.get(option.name)
        if field is None:
            if option.name not in TECSGEN_OPTIONS:
                yield _unknown(option)
            continue
        try:
            values[field.name] = field.metadata["parse"](option.value)
        except _RefusalError as refusal:
            message = f"{option.name} cannot be {option.value!r}: {refusal}"
            yield BAD_OPTION.at(
                option.value_span, message, hint=_default(field.default)
            )


def _unknown(option: PluginOption) -> Diagnostic:
    names = [*_FIELDS, *sorted(TECSGEN_OPTIONS)]
    folded = {name.lower(): name for name in names}
    from difflib import get_close_matches

    close = get_close_matches(option.name.lower(), folded, n=1)
    listed = f"the options are {', '.join(_FIELDS)}"
    hint = f"did you mean {folded[close[0]]}?" if close else listed
    message = f"RTCPlugin has no option {option.name}"
    return UNKNOWN_OPTION.at(option.span, message, hint=hint)


def _default(value: object) -> str | None:
    return f"the default is {value}" if value not in (None, "") else None
