"""Front end for modules of OpenRTM-aist-Python (rtc-template, RTCBuilder): read, never executed."""

from __future__ import annotations

import ast
import tokenize
import warnings
from dataclasses import dataclass
from io import BytesIO
from pathlib import Path

from rtgen.diagnostics import Diagnostic, Span
from rtgen.frontends.openrtm_python import rules
from rtgen.frontends.openrtm_python.reader import ModuleReader
from rtgen.model.rtc_profile import RtcProfile

_MAX_BYTES = 4 * 1024 * 1024


@dataclass(frozen=True, slots=True)
class ModuleResult:
    """What `read` gives: no profile if there are errors; `source` is the module's text.

    Beside a module that rtgen made, `generated`, there is an RtcProfile that says more.
    """

    profile: RtcProfile | None
    diagnostics: tuple[Diagnostic, ...]
    source: str
    generated: bool = False


def read(path: Path) -> ModuleResult:
    """The component of a module. Whatever is wrong with the file is in the diagnostics."""
    file = path.as_posix()
    start = Span(file, 1, 1, 1, 2)
    try:
        with path.open("rb") as stream:
            data = stream.read(_MAX_BYTES + 1)
        if len(data) > _MAX_BYTES:
            raise ValueError(f"it is larger than {_MAX_BYTES:,} bytes")
        encoding, _ = tokenize.detect_encoding(BytesIO(data).readline)
        source = data.decode(encoding)
    except (OSError, ValueError, SyntaxError) as error:
        reason = getattr(error, "strerror", None) or error
        found = rules.UNREADABLE.at(start, f"{file} cannot be read: {reason}")
        return ModuleResult(None, (found,), "")
    try:
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")
            tree = ast.parse(source, file)
    except SyntaxError as error:
        line, column = error.lineno or 1, max(error.offset or 1, 1)
        span = Span(file, line, column, line, column + 1)
        message = f"this is not Python 3: {error.msg}"
        hint = "convert a module for Python 2 first"
        return ModuleResult(
            None, (rules.UNREADABLE.at(span, message, hint=hint),), source
        )
    except (ValueError, RecursionError, MemoryError) as error:
        found = rules.UNREADABLE.at(start, f"{file} cannot be read: {error}")
        return ModuleResult(None, (found,), source)
    reader = ModuleReader(file)
    profile = reader.profile(tree)
    diagnostics = tuple(reader.diagnostics)
    return ModuleResult(profile, diagnostics, source, reader.generated)
