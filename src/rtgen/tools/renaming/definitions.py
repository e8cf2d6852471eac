"""The edits that rename what definitions name, where the index has it, and whether they can be."""

from __future__ import annotations

import re
from collections.abc import Iterable, Iterator
from pathlib import Path

from rtgen.compiler.diagnostics import Edit, InputError, Span
from rtgen.compiler.frontends.cdl.syntax import keywords as cdl_keywords
from rtgen.compiler.kit.resources import IDL_FILES, idl_file
from rtgen.compiler.project import shown
from rtgen.compiler.project_rules import NO_RENAME
from rtgen.compiler.typemap.idl_keywords import FOLDED
from rtgen.tools.indexing.components import component_key
from rtgen.tools.indexing.index import Definition, FileIndex, Index, Kind, Place

LANGUAGES = ("idl", "cdl", "rts", "bus", "component")
"""The languages of keys whose names can be changed."""

_NAME = re.compile(r"[^\W\d]\w*", re.ASCII)
_INSTANCE = re.compile(r"[\w.-]+")


class RenameError(InputError):
    """The name cannot be renamed, or not to the new one; the message says why."""

    def __init__(
        self, message: str, span: Span | None = None, hint: str | None = None
    ) -> None:
        super().__init__([NO_RENAME.at(span, message, hint=hint)])
        self.message = message


def language_of(key: str) -> str:
    """Return the language of a key."""
    return key.split(" ", 1)[0]


def alike(index: Index, key: str) -> list[str]:
    """Return the keys of a name: a component can have an IDL definition and a profile."""
    keys = [key]
    word = key.partition(" ")[2]
    if language_of(key) == "component":
        name, dot, rest = word.partition(".")
        for other in _components(index, name):
            keys.append(f"{other}::{rest}" if dot else other)
    elif language_of(key) == "idl":
        parts = word.split("::")
        for number in range(len(parts)):
            of = component_key(parts[number])
            tail = parts[number + 1 :]
            own = "idl " + "::".join(parts[: number + 1])
            if len(tail) < 2 and own in _components(index, parts[number]):
                keys.append(".".join((of, *tail)))
    return [each for each in keys if index.definition(each) is not None]


def _components(index: Index, name: str) -> list[str]:
    """Return the keys of the components of that name that IDL defines."""
    return [
        d.key
        for _, d in index.all()
        if d.kind is Kind.COMPONENT and d.name == name and d.key.startswith("idl ")
    ]


def named(index: Index, text: str) -> list[str]:
    """Return the keys that a user's text names, `Heater.power` or `Heating::Power::watt`.

    These are the outermost ones that end with it; several of equal depth are an error. Raises
    RenameError.
    """
    wanted = _parts(text)
    depths: dict[int, list[str]] = {}
    for _, definition in index.all():
        key = definition.key
        if language_of(key) not in LANGUAGES or not wanted:
            continue
        parts = _parts(key.partition(" ")[2].rpartition("#")[2].removeprefix("node "))
        if parts[-len(wanted) :] == wanted:
            depths.setdefault(len(parts), []).append(key)
    if not depths and len(wanted) > 1:
        return _enumerator(index, wanted)
    found = list(dict.fromkeys(depths[min(depths)])) if depths else []
    others = [key for key in found if key not in alike(index, found[0])]
    if others:
        texts = sorted(key.partition(" ")[2] for key in (found[0], *others))
        definition_ = index.definition(others[0])
        span = None if definition_ is None else span_of(index, definition_)
        hint = f"name one of {', '.join(texts)}"
        raise RenameError(f"{text} means several things", span, hint)
    return alike(index, found[0]) if found else []


def _enumerator(index: Index, wanted: list[str]) -> list[str]:
    """Return the key of `Enum::ENUMERATOR`: in IDL it is beside its enum, not in it."""
    enums = named(index, "::".join(wanted[:-1]))
    for key in enums:
        definition = index.definition(key)
        if definition is not None and definition.kind is Kind.ENUM:
            beside = f"{key.rpartition('::')[0] or 'idl '}::{wanted[-1]}"
            found = index.definition(beside.replace("idl ::", "idl "))
            if found is not None and found.kind is Kind.ENUMERATOR:
                return [found.key]
    return []


def _parts(text: str) -> list[str]:
    return [part for part in re.split(r"::|\.", text) if part]


def check(index: Index, key: str, name: str) -> Definition:
    """Return the definition of a key that can be renamed. Raises RenameError."""
    definition = index.definition(key)
    language = language_of(key)
    if definition is None or language not in LANGUAGES:
        called = definition.name if definition else key.split(" ", 1)[-1]
        raise RenameError(f"{called} is not defined by a name")
    span = span_of(index, definition)
    form = _INSTANCE if definition.kind is Kind.INSTANCE else _NAME
    if not form.fullmatch(name):
        raise RenameError(f"{name!r} is not a name", span)
    if language == "idl" and name.lower() in FOLDED:
        raise RenameError(f"{name} is a keyword of IDL", span)
    if language == "cdl" and name in cdl_keywords.RESERVED:
        raise RenameError(f"{name} is a keyword of CDL", span)
    siblings = index.inside(definition.container)
    if definition.kind is Kind.INSTANCE:
        file = key.partition("#")[0]
        siblings = [d for _, d in index.all() if d.key.partition("#")[0] == file]
    for sibling in siblings:
        if sibling.key != key and _same(sibling, name, language):
            message = f"there is a {sibling.kind} {sibling.name} beside it"
            raise RenameError(message, span_of(index, sibling))
    return definition


def edits(index: Index, keys: Iterable[str], name: str) -> Iterator[Edit]:
    """Yield the edits that rename keys. Raises RenameError."""
    for key in keys:
        definition = index.definition(key)
        for place in index.places(key):
            edit = _edit(place, definition, key, name)
            if edit is not None:
                yield edit


def _edit(
    place: Place, definition: Definition | None, key: str, name: str
) -> Edit | None:
    text = place.file.text
    written = text.source[place.start : place.end]
    called = key.rpartition("::")[2] if definition is None else definition.name
    span = text.span(displayed(place.file), place.start, place.end)
    if place.file.path in {str(idl_file(shipped)) for shipped in IDL_FILES}:
        raise RenameError(f"{called} is used in a file of rtgen itself", span)
    if written.lstrip("_") == called.lstrip("_"):
        return Edit(span, written, name)
    follows = place.file.path.endswith((".xml", ".yaml", ".yml", ".conf", ".toml"))
    if follows and language_of(key) != "bus":
        return None  # the outside name of a port, or the name of its service port
    raise RenameError(f"{called} comes from a macro, or is written so: {written}", span)


def displayed(file: FileIndex) -> str:
    """Return the displayed path of a file."""
    return shown(Path(file.path))


def span_of(index: Index, definition: Definition) -> Span:
    """Return the place of a definition's name."""
    file = index.definitions(definition.key)[0][0]
    return file.text.span(displayed(file), definition.start, definition.end)


def _same(definition: Definition, name: str, language: str) -> bool:
    if language == "idl":  # names of IDL that differ in case only clash
        return definition.name.lower() == name.lower()
    return definition.name == name
