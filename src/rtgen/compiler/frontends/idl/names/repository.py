"""Repository ids (CORBA 2.6, 10.6): prefixes, `#pragma ID` and `version`, CORBA 3's typeid."""

from __future__ import annotations

import re
from collections.abc import Callable
from sys import intern

from rtgen.compiler.diagnostics import Diagnostic, Related, Span
from rtgen.compiler.frontends.idl.names.scopes import Entity, Kind, Scope
from rtgen.compiler.frontends.idl.rules import repository as rules
from rtgen.compiler.frontends.idl.text.unit import Pragma
from rtgen.compiler.frontends.kit.suggestions import nearest

_PRAGMA = re.compile(r"\s*(\w+)\s*(.*?)\s*$", re.DOTALL)
_PREFIX = re.compile(r'"[^"]*"(?:\s*"[^"]*")*')
_ID = re.compile(r'((?:::\s*)?\w+(?:\s*::\s*\w+)*)\s+"([^"]*)"')
_VERSION = re.compile(r"((?:::\s*)?\w+(?:\s*::\s*\w+)*)\s+(\d+\.\d+)")
_IDL_FORM = re.compile(r"IDL:[^:]*:\d+\.\d+")
_SUPPORTED = ("prefix", "ID", "version", "once")
_FOREIGN = ("keylist", "DCPS_DATA_TYPE", "DCPS_DATA_KEY", "hdrstop")
"""Common pragmas of DDS products and of C++ compilers."""
_WITHOUT_ID = (Kind.MEMBER, Kind.ENUMERATOR, Kind.PARAMETER, Kind.PORT)

Find = Callable[[Scope, str, Span], Entity | None]


def repository_id(ids: str, name: str) -> str:
    """Return the repository id of a name: `IDL:path/name:1.0`.

    One string for all translation units that include the declaration.
    """
    return intern(f"IDL:{ids}/{name}:1.0" if ids else f"IDL:{name}:1.0")


def below(ids: str, name: str) -> str:
    """Return the prefix of the ids inside a scope."""
    return intern(f"{ids}/{name}") if ids else name


class Identities:
    """Applies pragmas and statements about repository ids; diagnostics go to `report`."""

    def __init__(self, find: Find, report: Callable[[Diagnostic], None]) -> None:
        self._find = find
        self._report = report

    def apply(self, pragma: Pragma, scope: Scope) -> None:
        """Apply `#pragma prefix`, `ID` or `version`; other pragmas are ignored."""
        match = _PRAGMA.match(pragma.text)
        kind, rest = (match[1], match[2]) if match else ("", "")
        if kind == "prefix":
            parts = _PREFIX.fullmatch(rest)
            if parts is None:
                self._malformed(pragma, '#pragma prefix "text"')
            else:
                scope.ids = "".join(rest.split('"')[1::2])
        elif kind == "ID":
            parts = _ID.fullmatch(rest)
            if parts is None:
                self._malformed(pragma, '#pragma ID name "IDL:text:1.0"')
            else:
                entity = self._find(scope, parts[1], pragma.span)
                if entity is not None:
                    self.set_id(entity, parts[2], pragma.span)
        elif kind == "version":
            parts = _VERSION.fullmatch(rest)
            if parts is None:
                self._malformed(pragma, "#pragma version name major.minor")
            else:
                entity = self._find(scope, parts[1], pragma.span)
                if entity is not None:
                    self._set_version(entity, parts[2], pragma.span)
        elif kind and kind not in _FOREIGN:
            near = nearest(kind, (*_SUPPORTED, *_FOREIGN))
            hint = (
                f"did you mean {near}?"
                if near
                else "it is let pass, as it may be for another tool"
            )
            message = f"the pragma {kind} is ignored"
            self._report(rules.UNKNOWN_PRAGMA.at(pragma.span, message, hint=hint))

    def _malformed(self, pragma: Pragma, form: str) -> None:
        self._report(
            rules.BAD_PRAGMA.at(pragma.span, "malformed pragma", hint=f"write {form}")
        )

    def set_id(self, entity: Entity, text: str, span: Span) -> None:
        """Set the repository id of an entity from a pragma or a typeid statement."""
        if not self._can_have_id(entity, span):
            return
        if ":" not in text or (
            text.startswith("IDL:") and not _IDL_FORM.fullmatch(text)
        ):
            self._report(
                rules.ODD_ID.at(
                    span,
                    f'"{text}" is not a usual repository id',
                    hint="write IDL:path/name:1.0",
                )
            )
        if self._set(entity, text, span):
            entity.fixed_id = span

    def _set_version(self, entity: Entity, version: str, span: Span) -> None:
        if self._can_have_id(entity, span):
            start, _, _ = entity.repository_id.rpartition(":")
            if self._set(entity, f"{start}:{version}", span):
                entity.fixed_version = span

    def _can_have_id(self, entity: Entity, span: Span) -> bool:
        if entity.kind not in _WITHOUT_ID:
            return True
        self._report(
            rules.NO_ID.at(
                span,
                f"the {entity.kind} {entity.scoped} has no id",
                related=[Related(entity.span, "declared here")],
                hint="name the type or interface that holds it",
            )
        )
        return False

    def _set(self, entity: Entity, text: str, span: Span) -> bool:
        """Set the id; False, after a diagnostic, if another statement sets it differently."""
        before = entity.fixed_id or entity.fixed_version
        if before is None or entity.repository_id == text:
            entity.repository_id = text
            return True
        self._report(
            rules.CONFLICT.at(
                span,
                f"{entity.scoped} has the repository id {entity.repository_id} already",
                related=[Related(before, "set here")],
                hint="remove one of the two",
            )
        )
        return False
