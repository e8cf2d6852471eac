"""Signatures and functions of CDL files by name, and values from text."""

from __future__ import annotations

import json
from dataclasses import dataclass
from pathlib import Path

from rtgen.compiler.diagnostics import InputError, has_errors
from rtgen.compiler.layouts.tdr import TransferError
from rtgen.compiler.model.tecs import Signature, TecsUnit
from rtgen.facts.cdl_files import CDL_SUFFIXES
from rtgen.facts.encodings import decode
from rtgen.facts.files import UnreadableError, read_file
from rtgen.runtime.opaque_rpc import REPLY_LIMIT, ReplyOrder, Tdr
from rtgen.tools.kit.exits import Refusal
from rtgen.tools.kit.json_text import parse_json
from rtgen.tools.rpc.codecs import Function, Service
from rtgen.tools.rpc.values import Json


@dataclass(frozen=True, slots=True)
class Wire:
    """Data representation and order of replies of the other end."""

    tdr: Tdr
    reply: ReplyOrder


@dataclass(frozen=True, slots=True)
class Peer:
    """The options for the other end; `timeout` in seconds."""

    wire: Wire
    timeout: float


@dataclass(frozen=True, slots=True)
class CdlFiles:
    """The CDL file of a command; without one, those among the sources of the project."""

    file: Path | None = None
    include: tuple[str, ...] = ()

    def units(self) -> list[TecsUnit]:
        """Read the declarations; only errors are reported. Raises InputError, Refusal."""
        from rtgen.compiler.frontends import cdl
        from rtgen.compiler.frontends.stage import ending_with
        from rtgen.compiler.project import is_other_kind, load

        project = load()
        if self.file is not None and is_other_kind(self.file, CDL_SUFFIXES):
            raise Refusal(f"{self.file} is not a CDL file")
        paths = [self.file] if self.file is not None else None
        paths = paths or ending_with(project.sources, CDL_SUFFIXES)
        if not paths:
            raise Refusal(
                "which CDL file? Give --cdl FILE: no project with one is around this folder"
            )
        folders = [*map(Path, self.include), *project.include, *project.tecs_path]
        result = cdl.load(
            paths,
            root=project.root,
            include=folders,
            define=dict(project.define),
            encoding=project.encoding,
            prelude=project.prelude == "kernel",
        )
        if has_errors(result.diagnostics):
            raise InputError(list(result.diagnostics))
        return list(result.model.tecs)

    def signatures(self) -> list[tuple[TecsUnit, Signature]]:
        """Return the signatures, each with the first unit that has it."""
        by_place: dict[object, tuple[TecsUnit, Signature]] = {}
        for unit in self.units():
            for signature in signatures_of(unit):
                place = (signature.span.file, signature.span.line, signature.scoped)
                by_place.setdefault(place, (unit, signature))
        return [*by_place.values()]

    def service(self, name: str, wire: Wire, limit: int = REPLY_LIMIT) -> Service:
        """Find the service of a signature by name; `limit` as for `service_of`. Raises Refusal."""
        signatures = self.signatures()
        name = name.removeprefix("::")
        units = {s.span.file: unit for unit, s in signatures if s.scoped == name}
        if not units:
            raise _unknown(
                f"no signature {name!r}", name, [s.scoped for _, s in signatures]
            )
        if len(units) > 1:
            raise Refusal(
                f"the signature {name!r} is in {' and '.join(units)}: --cdl names one"
            )
        [unit] = units.values()
        return service_of(unit, name, wire, limit)

    def function(self, name: str, wire: Wire) -> Function:
        """Find the function `SIG.FUNC`. Raises Refusal."""
        signature, dot, function = name.rpartition(".")
        if not dot:
            raise Refusal(f"{name!r}: name the function as SIGNATURE.FUNCTION")
        service = self.service(signature, wire)
        if function not in service.functions:
            raise _unknown(
                f"no function {function!r}", function, list(service.functions)
            )
        return service.functions[function]


def signatures_of(unit: TecsUnit) -> list[Signature]:
    """Return the signatures of a unit."""
    return [d for d in unit.declarations if isinstance(d, Signature)]


def service_of(
    unit: TecsUnit, name: str, wire: Wire, limit: int = REPLY_LIMIT
) -> Service:
    """Find the service of a signature by name. Raises Refusal.

    `limit`: maximum octets of arrays and texts in a request that is read.
    """
    signatures = {d.scoped: d for d in signatures_of(unit)}
    signature = signatures.get(name.removeprefix("::"))
    if signature is None:
        raise _unknown(f"no signature {name!r}", name, list(signatures))
    try:
        return Service(unit, signature, wire.tdr, wire.reply, limit)
    except TransferError as error:
        raise Refusal(f"{error.span.file}:{error.span.line}: {error}") from error


def parsed(text: str) -> Json:
    """Parse JSON from the command line. Raises Refusal."""
    try:
        value: Json = parse_json(text)
    except (ValueError, RecursionError) as error:
        raise Refusal(f"{text[:40]!r} is not JSON: {error}") from error
    return value


def printed(value: Json) -> str:
    """Format JSON as one line with a newline."""
    return f"{json.dumps(value)}\n"


def content(path: Path) -> str:
    """Read a text. Raises Refusal."""
    try:
        return decode(read_file(path), standard=True).normal
    except UnreadableError as error:
        raise Refusal(f"cannot read {path}: {error}") from error


def octets(text: str) -> bytes:
    """Parse hex digits. Raises Refusal."""
    try:
        return bytes.fromhex(text)
    except ValueError as error:
        digits = "hex digits, two for each octet"
        raise Refusal(f"{text[:40]!r} is not hex: write {digits}") from error


def _unknown(message: str, name: str, names: list[str]) -> Refusal:
    from difflib import get_close_matches

    close = get_close_matches(name, names, n=1)
    hint = f"did you mean {close[0]!r}?" if close else f"known: {', '.join(names)}"
    return Refusal(f"{message}; {hint}")
