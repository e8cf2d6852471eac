"""The part of an IDL text that is being written, and what may stand there.

It is found in the tokens before a position, since a text that is being written has no tree.
"""

from __future__ import annotations

import re
from collections.abc import Sequence
from dataclasses import dataclass, field, replace
from string import ascii_letters, digits

from rtgen.compiler.frontends.idl.names.annotation_definitions import (
    DEFINITIONS,
    FLAG,
    TYPED,
)
from rtgen.tools.indexing.index import Kind

_TOKEN = re.compile(
    r"""//[^\n]*|/\*.*?(?:\*/|\Z)|^[ \t]*\#(?:[^\\\n]|\\.)*|"(?:\\.|[^"\\\n])*"?"""
    r"""|'(?:\\.|[^'\\\n])*'?|@\s*\w*|(?:::)?[A-Za-z_]\w*(?:::\w*)*|[^\s\w]|\w+""",
    re.DOTALL | re.MULTILINE,
)
_OPEN = {"(": ")", "[": "]", "<": ">"}

TYPES = frozenset(
    (Kind.STRUCT, Kind.UNION, Kind.ENUM, Kind.BITS, Kind.TYPEDEF, Kind.INTERFACE)
)
VALUES = frozenset((Kind.CONSTANT, Kind.ENUMERATOR))
RECORDS = frozenset((Kind.STRUCT, Kind.UNION))


def _words(text: str) -> tuple[str, ...]:
    return tuple(text.split())


_BASIC = _words(
    "boolean char double float long octet sequence short string unsigned any fixed Object wchar"
    " wstring int8 int16 int32 int64 uint8 uint16 uint32 uint64 map"
)
_DECLARATIONS = _words(
    "struct interface component enum typedef const module union exception bitmask bitset valuetype"
    " eventtype abstract local native custom home import typeid typeprefix"
)
_PORTS = ("provides", "uses", "publishes", "consumes", "emits", "attribute")
_EXPORTS = _words(
    "void oneway attribute readonly raises typedef struct union enum const exception native"
)
_BODIES = frozenset(
    _words(
        "struct exception union enum bitset bitmask interface valuetype eventtype component module"
        " home porttype connector"
    )
)
_LONGER = {
    "unsigned": ("short", "long"),
    "long": ("long", "double"),
    "unsigned long": ("long",),
    "readonly": ("attribute",),
    "oneway": ("void",),
    "uses": ("multiple",),
    "abstract": ("interface", "valuetype"),
    "local": ("interface",),
    "custom": ("valuetype",),
}
_AFTER_NAME = {
    "union": ("switch",),
    "component": ("supports",),
    "valuetype": ("supports",),
    "eventtype": ("supports",),
    "home": ("supports", "manages"),
}
_PORT_KINDS = {
    **dict.fromkeys(("publishes", "consumes", "emits"), RECORDS),
    **dict.fromkeys(("provides", "uses"), frozenset((Kind.INTERFACE,))),
}
_BASES = {
    "interface": Kind.INTERFACE,
    "component": Kind.COMPONENT,
    "home": Kind.COMPONENT,
    "struct": Kind.STRUCT,
    "bitset": Kind.STRUCT,
    "valuetype": Kind.STRUCT,
    "eventtype": Kind.STRUCT,
}
_PLACES = {
    "struct": ("member",),
    "exception": ("member",),
    "valuetype": ("member", "operation", "attribute"),
    "union": ("case",),
    "enum": ("enumerator",),
    "bitmask": ("bit_value",),
    "bitset": ("bitfield",),
    "interface": ("operation", "attribute", "typedef", "constant"),
    "component": ("port", "configuration"),
}
_NEXT_PLACES = {
    **dict.fromkeys(("publishes", "consumes", "emits", "provides", "uses"), "port"),
    **{word: word for word in _BODIES | {"typedef"}},
    "eventtype": "valuetype",
    "const": "constant",
    "abstract": "interface",
    "local": "interface",
}
_WORD = f"{ascii_letters}{digits}_"
_FIRST = ("unit", "min", "max", "range", "default", "key", "optional", "name")
"""Annotations that are used most, in this order."""


@dataclass(frozen=True, slots=True)
class Expected:
    """What may stand at a position: definitions of these kinds, and words, the likeliest first.

    `annotations` are those that fit what follows. With `through`, a typedef must name one of the
    other kinds. `scope` has the names of the scopes around the position, outermost first.
    """

    kinds: frozenset[Kind] = frozenset()
    words: tuple[str, ...] = ()
    annotations: tuple[str, ...] = ()
    through: bool = False
    scope: tuple[str, ...] = ()


@dataclass(slots=True)
class _Statement:
    """The tokens of the statement at a position, without annotations.

    `body` is the kind of the definition around it, `brackets` the open ones, each with the number
    of tokens before it; `annotation` is the one whose arguments the position is in.
    """

    body: str = "module"
    tokens: list[str] = field(default_factory=list)
    brackets: list[tuple[str, int]] = field(default_factory=list)
    annotation: str = ""
    arguments: list[str] = field(default_factory=list)
    scope: tuple[str, ...] = ()


def expected(source: str, offset: int) -> Expected:
    """Return what may stand where the word that ends at an offset begins."""
    before = re.search(r"[\w:]*\Z", source[:offset])
    start = offset if before is None else before.start()
    if source[:start].endswith("@"):
        statement = _statement(source[: start - 1])
        return Expected(annotations=_annotations(statement, source[offset:]))
    statement = _statement(source[:start])
    wanted = _argument(statement) if statement.annotation else _in_statement(statement)
    return replace(wanted, scope=statement.scope)


def _statement(text: str) -> _Statement:
    """Return the statement that a text ends in."""
    outer: list[_Statement] = []
    now = _Statement()
    depth = 0
    last = ""
    for match in _TOKEN.finditer(text):
        token = match[0]
        if token.startswith(("//", "/*")) or token.lstrip().startswith("#"):
            continue
        if token.startswith("@"):
            last = token
            continue
        if depth:
            depth += (token == "(") - (token == ")")
            now.arguments.append(token)
            now.annotation = now.annotation if depth else ""
            continue
        if last and token == "(":
            depth, now.annotation, now.arguments = 1, last[1:].strip(), []
            last = ""
            continue
        last = ""
        if token == "{":
            outer.append(now)
            now = _inside(now)
        elif token == "}":
            around = outer.pop() if outer else _Statement()
            now = _Statement(around.body, ["}"], scope=around.scope)
        elif token == ";" or (token == "," and now.body in ("enum", "bitmask")):
            now = _Statement(now.body, scope=now.scope)
        elif token == ":" and now.tokens[:1] in (["case"], ["default"]):
            now.tokens = []
        else:
            if token in _OPEN:
                now.brackets.append((token, len(now.tokens)))
            elif now.brackets and token == _OPEN[now.brackets[-1][0]]:
                now.brackets.pop()
            now.tokens.append(token)
    return now


def _inside(head: _Statement) -> _Statement:
    """Return the beginning of the body of a definition."""
    places = [place for place, word in enumerate(head.tokens) if word in _BODIES]
    if not places or places[0] + 1 == len(head.tokens):
        return _Statement(scope=head.scope)
    kind, name = head.tokens[places[0] : places[0] + 2]
    return _Statement(kind, scope=(*head.scope, name))


def _argument(statement: _Statement) -> Expected:
    """Return what may stand among the arguments of an annotation."""
    definition = DEFINITIONS.get(statement.annotation)
    if definition is None:
        return Expected()
    given = statement.arguments[-2:]
    if not given or given[-1] == ",":
        names = tuple(definition.arguments) if len(definition.arguments) > 1 else ()
        words = definition.words.get("value", ())
        if definition.arguments.get("value") in (TYPED, FLAG):
            words = ("TRUE", "FALSE")
        return Expected(VALUES, (*words, *names))
    if given[-1] == "=":
        return Expected(VALUES, definition.words.get(given[0], ()))
    return Expected()


def _in_statement(now: _Statement) -> Expected:
    if now.brackets:
        opened, place = now.brackets[-1]
        return _in_brackets(opened, now.tokens[:place], now.tokens[place + 1 :])
    tokens = now.tokens
    if not tokens or tokens == ["}"]:
        return _at_start(now.body) if not tokens else Expected()
    if "=" in tokens or tokens[0] == "case":
        return Expected(VALUES, ("TRUE", "FALSE"))
    first, last = tokens[0], tokens[-1]
    if last in ("supports", ",") and "supports" in tokens:
        return Expected(frozenset((Kind.INTERFACE,)))
    if last == "manages":
        return Expected(frozenset((Kind.COMPONENT,)))
    if ":" in tokens and last in (":", ",", "truncatable"):
        base = next((word for word in tokens if word in _BASES), "")
        return Expected(frozenset((_BASES[base],))) if base else Expected()
    if first in _PORT_KINDS:
        if len(tokens) > 1 and tokens[1:] != ["multiple"]:
            return Expected()
        kinds = _PORT_KINDS[first] | {Kind.TYPEDEF}
        return Expected(kinds, _LONGER.get(last, ()), through=True)
    if last in ("typedef", "attribute", "const", "oneway", "public", "private"):
        if last == "const":
            named = frozenset((Kind.TYPEDEF, Kind.ENUM, Kind.BITS))
            return Expected(named, _BASIC)
        return Expected(TYPES, _LONGER.get(last, _BASIC))
    if last == ")" and now.body in ("interface", "valuetype"):
        return Expected(words=("raises",))
    if len(tokens) > 1 and tokens[-2] in _AFTER_NAME:
        return Expected(words=_AFTER_NAME[tokens[-2]])
    if last == "module":
        return Expected(frozenset((Kind.MODULE,)))
    if last == ">" or last in _BODIES:
        return Expected()
    return Expected(words=_LONGER.get(" ".join(tokens[-2:]), _LONGER.get(last, ())))


def _in_brackets(opened: str, before: Sequence[str], inner: Sequence[str]) -> Expected:
    last = inner[-1] if inner else ""
    head = before[-1] if before else ""
    if opened == "[":
        return Expected(VALUES)
    if opened == "<":
        if head in ("sequence", "map") and not inner:
            return Expected(TYPES, _BASIC)
        if head == "map" and inner.count(",") == 1 and last == ",":
            return Expected(TYPES, _BASIC)
        if last in ("", ","):
            return Expected(VALUES)
        return Expected(words=_LONGER.get(" ".join(inner[-2:]), _LONGER.get(last, ())))
    if head in ("raises", "getraises", "setraises"):
        return (
            Expected(frozenset((Kind.EXCEPTION,))) if last in ("", ",") else Expected()
        )
    if head == "switch":
        words = ("boolean", "char", "long", "octet", "short", "unsigned", "wchar")
        return Expected(frozenset((Kind.ENUM, Kind.TYPEDEF)), words)
    if "=" in before:
        return Expected(VALUES)
    if last in ("", ","):
        return Expected(words=("in", "out", "inout"))
    if last in ("in", "out", "inout"):
        return Expected(TYPES, _BASIC)
    return Expected(words=_LONGER.get(last, ()))


def _at_start(body: str) -> Expected:
    """Return what may begin a statement of a body."""
    match body:
        case "module":
            return Expected(words=_DECLARATIONS)
        case "component" | "porttype" | "connector":
            return Expected(words=_PORTS)
        case "struct" | "exception":
            return Expected(TYPES, _BASIC)
        case "union":
            return Expected(TYPES, ("case", "default", *_BASIC))
        case "interface" | "home":
            return Expected(TYPES, (*_EXPORTS, *_BASIC))
        case "valuetype" | "eventtype":
            words = ("public", "private", "factory", *_EXPORTS, *_BASIC)
            return Expected(TYPES, words)
        case "bitset":
            return Expected(words=("bitfield",))
        case _:
            return Expected()


def _annotations(statement: _Statement, after: str) -> tuple[str, ...]:
    """Return the names of annotations that may stand before a text, the most used first."""
    places = _places(statement, after)
    usual = {name: number for number, name in enumerate(_FIRST)}
    names = [name for name, d in DEFINITIONS.items() if places & d.places]
    return tuple(sorted(names, key=lambda name: usual.get(name, len(usual))))


def _places(statement: _Statement, after: str) -> frozenset[str]:
    """Return the places of annotations that a statement and the text after it may be."""
    if statement.brackets and statement.brackets[-1][0] == "(":
        return frozenset(("parameter",))
    words = [*statement.tokens, *_next_words(after)]
    body = "valuetype" if statement.body == "eventtype" else statement.body
    own = _PLACES.get(body, tuple(_NEXT_PLACES.values()))
    if not words:
        return frozenset(own)
    if "attribute" in words[:2]:
        return frozenset(("configuration" if body == "component" else "attribute",))
    if words[0] in _NEXT_PLACES:
        return frozenset((_NEXT_PLACES[words[0]],))
    if body == "interface":
        return frozenset(("operation",))
    return frozenset(place for place in own if place in ("member", *own[:1]))


def _next_words(after: str) -> list[str]:
    """Return the next words of a text up to the end of a statement, without annotations."""
    now = _Statement()
    depth = 0
    written = len(after) - len(after.lstrip(_WORD))
    for match in _TOKEN.finditer(after, written):
        token = match[0]
        if token.startswith(("//", "/*", "@")):
            continue
        if token in "()":
            depth += 1 if token == "(" else -1
            continue
        if depth:
            continue
        if not (token[0].isalpha() or token[0] in "_:"):
            break
        now.tokens.append(token)
        if len(now.tokens) == 2:
            break
    return now.tokens
