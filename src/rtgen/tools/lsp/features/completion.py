"""Completion: names that are valid at a position, keywords, annotations, files, keys."""

from __future__ import annotations

import re
from collections.abc import Iterator
from pathlib import Path

from lsprotocol.types import (
    CompletionItem,
    CompletionItemKind,
    CompletionList,
    Position,
)

from rtgen.compiler.frontends.cdl.syntax import keywords as cdl_keywords
from rtgen.compiler.frontends.idl.names.annotation_definitions import DEFINITIONS
from rtgen.compiler.kit.resources import IDL_FILES
from rtgen.facts.device_files import DEVICE_SUFFIXES
from rtgen.facts.idl_files import IDL_SUFFIXES
from rtgen.tools.indexing.index import Definition, Index, Kind
from rtgen.tools.lsp.documents import Language
from rtgen.tools.lsp.features import schema
from rtgen.tools.lsp.features.idl_context import TYPES, Expected, expected
from rtgen.tools.lsp.workspace import View

MAX_ITEMS = 500
"""Maximum number of items in a response; beyond it, the editor asks again after each letter."""

_ITEMS = {
    Kind.FILE: CompletionItemKind.File,
    Kind.MODULE: CompletionItemKind.Module,
    Kind.STRUCT: CompletionItemKind.Struct,
    Kind.UNION: CompletionItemKind.Struct,
    Kind.EXCEPTION: CompletionItemKind.Struct,
    Kind.ENUM: CompletionItemKind.Enum,
    Kind.ENUMERATOR: CompletionItemKind.EnumMember,
    Kind.BITS: CompletionItemKind.Enum,
    Kind.TYPEDEF: CompletionItemKind.TypeParameter,
    Kind.CONSTANT: CompletionItemKind.Constant,
    Kind.INTERFACE: CompletionItemKind.Interface,
    Kind.OPERATION: CompletionItemKind.Method,
    Kind.PARAMETER: CompletionItemKind.Variable,
    Kind.ATTRIBUTE: CompletionItemKind.Property,
    Kind.MEMBER: CompletionItemKind.Field,
    Kind.COMPONENT: CompletionItemKind.Class,
    Kind.PORT: CompletionItemKind.Event,
    Kind.SIGNATURE: CompletionItemKind.Interface,
    Kind.FUNCTION: CompletionItemKind.Method,
    Kind.CELLTYPE: CompletionItemKind.Class,
    Kind.CELL: CompletionItemKind.Variable,
    Kind.DEVICE: CompletionItemKind.Class,
    Kind.OBJECT: CompletionItemKind.Property,
    Kind.NODE: CompletionItemKind.Variable,
    Kind.INSTANCE: CompletionItemKind.Variable,
}
_SCOPED = re.compile(r"((?:::)?(?:\w+::)+)(\w*)$", re.ASCII)
_INCLUDE = re.compile(r"^\s*#\s*include\s*[\"<]([^\">]*)$")
_IMPORT = re.compile(r"^\s*import\s*\(\s*[\"<]([^\">]*)$")
_JOINED = re.compile(r"(\w+)\.(\w*)$")
_CELL = re.compile(r"\bcell\s+\w*$")
_PORT = re.compile(r"\b(?:call|entry)\s+\w*$")
_EDS_KEYS = (
    *("ParameterName", "ObjectType", "DataType", "AccessType", "DefaultValue"),
    *("PDOMapping", "LowLimit", "HighLimit", "SubNumber", "ObjFlags", "CompactSubObj"),
)
_SCOPES = frozenset((Kind.MODULE, Kind.INTERFACE, Kind.STRUCT, Kind.COMPONENT))
_NAMED = TYPES | {Kind.CONSTANT, Kind.EXCEPTION, Kind.ENUMERATOR, Kind.COMPONENT}
_VALUE = re.compile(r"[\w:]*type(?:Name)?\s*[:=]\s*[\"']?[\w:]*$", re.IGNORECASE)


def completion(view: View, position: Position) -> CompletionList:
    """Return the completions at a position."""
    offset = view.offset(position)
    source = view.text.source
    line = source[source.rfind("\n", 0, offset) + 1 : offset]
    items: list[CompletionItem] = []
    seen: set[str] = set()
    complete = True
    for item in _proposed(view, line, offset):
        if item.label in seen:
            continue
        if len(items) == MAX_ITEMS:
            complete = False
            break
        seen.add(item.label)
        # Editors sort by label otherwise.
        item.sort_text = f"{len(items):04}"
        items.append(item)
    return CompletionList(is_incomplete=not complete, items=items)


def _proposed(view: View, line: str, offset: int) -> Iterator[CompletionItem]:
    match view.language:
        case Language.IDL:
            return _idl(view, line, offset)
        case Language.CDL:
            return _cdl(view, line, offset)
        case Language.BUS:
            return _bus(view, line, offset)
        case Language.PROJECT:
            return _project(view, line, offset)
        case Language.XDD:
            return iter(())
        case Language.EDS:
            return iter(() if "=" in line else map(_property, _EDS_KEYS))
        case Language.PROFILE:
            return _types(view.index) if _VALUE.search(line) else iter(())


def _item(d: Definition, label: str | None = None) -> CompletionItem:
    detail = f"{d.kind} {d.detail}".strip()
    return CompletionItem(label or d.name, kind=_ITEMS[d.kind], detail=detail)


def _property(name: str, detail: str = "") -> CompletionItem:
    kind = CompletionItemKind.Property
    return CompletionItem(name, kind=kind, documentation=detail or None)


def _keyword(word: str) -> CompletionItem:
    return CompletionItem(word, kind=CompletionItemKind.Keyword)


def _files(view: View, suffixes: tuple[str, ...], written: str) -> Iterator[Path]:
    """Yield the files beside the document and in the include folders of its project."""
    folders = [Path(view.document.path).parent]
    if view.analysis is not None:
        folders += view.analysis.project.include
    inner = written.rpartition("/")[0]
    for folder in folders:
        below = folder / inner
        if below.is_dir():
            for path in sorted(below.iterdir())[:MAX_ITEMS]:
                if path.suffix.lower() in suffixes and path.is_file():
                    yield path


# IDL


def _idl(view: View, line: str, offset: int) -> Iterator[CompletionItem]:
    if (match := _INCLUDE.match(line)) is not None:
        for path in _files(view, (*IDL_SUFFIXES, ".inc"), match[1]):
            yield CompletionItem(path.name, kind=CompletionItemKind.File)
        for name in IDL_FILES:
            yield CompletionItem(name, kind=CompletionItemKind.File)
        return
    wanted = expected(view.text.source, offset)
    for name in wanted.annotations:
        arguments = ", ".join(DEFINITIONS[name].arguments)
        kind = CompletionItemKind.Property
        detail = f"@{name}({arguments})" if arguments else f"@{name}"
        yield CompletionItem(name, kind=kind, detail=detail)
    if wanted.annotations:
        return
    depths = range(len(wanted.scope), -1, -1)
    scopes = [f"idl {'::'.join(wanted.scope[:depth])}" for depth in depths if depth] + [
        ""
    ]
    if (match := _SCOPED.search(line)) is not None:
        parts = [part for part in match[1].split("::") if part]
        for key in _resolved(view.index, parts, scopes, match[1].startswith("::")):
            yield from (_item(d) for d in _fitting(view.index, key, wanted))
        return
    for scope in scopes:
        yield from (_item(d) for d in _fitting(view.index, scope, wanted))
    yield from map(_keyword, wanted.words)


def _fitting(index: Index, scope: str, wanted: Expected) -> Iterator[Definition]:
    """Yield the definitions of a scope that fit, then those through which one gets to such."""
    inside = [d for d in index.inside(scope) if d.key.startswith("idl ")]
    yield from (d for d in inside if _is_fitting(index, d, wanted))
    for d in inside:
        if d.kind not in _SCOPES or _is_fitting(index, d, wanted):
            continue
        if next(_fitting(index, d.key, wanted), None) is not None:
            yield d


def _is_fitting(index: Index, d: Definition, wanted: Expected) -> bool:
    """Return whether a definition may stand where something is expected."""
    if d.kind not in wanted.kinds:
        return False
    seen: set[str] = set()
    while wanted.through and d.kind is Kind.TYPEDEF:
        target = _named(index, d)
        if target is None or d.key in seen:
            return False
        seen.add(d.key)
        d = target
    return d.kind in wanted.kinds


def _named(index: Index, typedef: Definition) -> Definition | None:
    """Return the definition that a typedef gives another name."""
    scope = typedef.key.removeprefix("idl ").split("::")[:-1]
    for depth in range(len(scope), -1, -1):
        key = "::".join([*scope[:depth], typedef.detail.removeprefix("::")])
        if (target := index.definition(f"idl {key}")) is not None:
            return target
    return None


def _resolved(
    index: Index, parts: list[str], scopes: list[str], absolute: bool
) -> Iterator[str]:
    """Yield the key that a scoped name refers to, by the keys of scopes from the innermost on."""
    for scope in [""] if absolute else scopes:
        outer = scope.removeprefix("idl ").split("::") if scope else []
        key = "idl " + "::".join([*outer, *parts])
        if index.definitions(key):
            yield key
            return


def _types(index: Index) -> Iterator[CompletionItem]:
    """Yield all IDL types and interfaces by scoped name."""
    for _, d in index.all():
        if d.key.startswith("idl ") and d.kind in _NAMED:
            yield _item(d, d.key.removeprefix("idl "))


# CDL


def _cdl(view: View, line: str, offset: int) -> Iterator[CompletionItem]:
    if (match := _IMPORT.match(line)) is not None:
        for path in _files(view, (".cdl",), match[1]):
            yield CompletionItem(path.name, kind=CompletionItemKind.File)
        return
    definitions = [d for _, d in view.index.all() if d.key.startswith("cdl ")]
    if (match := _JOINED.search(line)) is not None:
        celltypes = {
            d.detail.rpartition("::")[2]
            for d in definitions
            if d.kind is Kind.CELL and d.name == match[1]
        } or {match[1]}
        for d in definitions:
            if d.kind is Kind.CELLTYPE and d.name in celltypes:
                for port in view.index.inside(d.key):
                    if port.detail.startswith("entry"):
                        yield _item(port)
        return
    if _CELL.search(line):
        yield from (_item(d) for d in definitions if d.kind is Kind.CELLTYPE)
        return
    if _PORT.search(line):
        yield from (_item(d) for d in definitions if d.kind is Kind.SIGNATURE)
        return
    around = view.file.around(view.shift.back(offset)) if view.file else []
    cell = next((d for d in reversed(around) if d.kind is Kind.CELL), None)
    if cell is not None and "=" not in line:
        for d in definitions:
            if d.kind is Kind.CELLTYPE and d.name == cell.detail.rpartition("::")[2]:
                for member in view.index.inside(d.key):
                    if not member.detail.startswith("entry"):
                        yield _item(member)
        return
    nameable = (Kind.CELL, Kind.TYPEDEF, Kind.CONSTANT, Kind.SIGNATURE, Kind.CELLTYPE)
    yield from (_item(d) for d in definitions if d.kind in nameable)
    words = cdl_keywords.RESERVED | cdl_keywords.SPECIFIERS
    yield from map(_keyword, sorted(w for w in words if not w.startswith("__")))


# TOML


def _bus(view: View, line: str, offset: int) -> Iterator[CompletionItem]:
    table = schema.table_at(view.text.source, offset)
    name, equals, _ = line.partition("=")
    if not equals and table[:1] in (("device",), ("node",)) and len(table) == 3:
        yield from _objects(view, table[1])
    elif not equals:
        for key, description in schema.bus_keys(table):
            yield _property(key, description)
    elif name.strip() == "device":
        definitions = [d for _, d in view.index.all() if d.kind is Kind.DEVICE]
        yield from map(_item, definitions)
    elif name.strip() == "eds":
        for path in _files(view, DEVICE_SUFFIXES, ""):
            yield CompletionItem(path.name, kind=CompletionItemKind.File)
    elif table[:1] == ("device",) and len(table) == 2:
        yield from _objects(view, table[1])
    else:
        words = schema.bus_table((*table, name.strip())).get("enum", ())
        for value in words:
            yield CompletionItem(str(value), kind=CompletionItemKind.Value)


def _objects(view: View, name: str) -> Iterator[CompletionItem]:
    """Yield the objects of a kind of device, or of a node's kind."""
    for bus in view.analysis.model.buses if view.analysis else ():
        kinds = [
            *(kind for kind in bus.kinds if kind.name == name),
            *(node.kind for node in bus.nodes if node.name == name),
        ]
        for kind in kinds[:1]:
            for v in kind.device.variables:
                single = v.subindex == 0 and kind.device.find(v.index, 1) is None
                label = f"{v.index:04X}" if single else f"{v.index:04X}:{v.subindex:X}"
                yield CompletionItem(
                    label, kind=CompletionItemKind.Property, detail=v.name
                )


def _project(view: View, line: str, offset: int) -> Iterator[CompletionItem]:
    table = schema.table_at(view.text.source, offset)
    name, equals, _ = line.partition("=")
    if line.lstrip().startswith("["):
        yield from (_property(key) for key, _ in schema.project_keys(()))
    elif not equals:
        yield from (_property(key) for key, _ in schema.project_keys(table))
    elif table[:1] == ("adapter",) and name.strip() in ("from", "to"):
        yield from _types(view.index)
