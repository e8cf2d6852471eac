"""Converts declarations parsed by pycparser to types of the model."""

from __future__ import annotations

import re
from collections.abc import Iterable, Iterator, Mapping
from typing import Any

from msgspec.structs import replace
from pycparser import c_ast
from pycparser.c_parser import CParser, ParseError

from rtgen.compiler.diagnostics import Span
from rtgen.compiler.frontends.cdl.names.c_types import MAX_DEPTH, depth, opaque
from rtgen.compiler.frontends.cdl.syntax.keywords import RESERVED
from rtgen.compiler.model.c_types import (
    CArrayType,
    CEnumType,
    CFunctionType,
    CPointerType,
    CScalarType,
    CStructType,
    CType,
    CTypedefType,
)
from rtgen.compiler.model.tecs import (
    TecsDeclaration,
    TecsEnum,
    TecsMember,
    TecsStruct,
    TecsTypedef,
)
from rtgen.facts.tdr import Scalar

_NAMED = {
    **{kind.value: kind for kind in Scalar if kind.value.endswith("_t")},
    "size_t": Scalar.ULONG,
}
"""Names that denote a CDL type even if a header declares them differently."""

_BASIC = {
    "void": Scalar.VOID,
    "_Bool": Scalar.BOOL,
    "char": Scalar.CHAR,
    "char signed": Scalar.SCHAR,
    "char unsigned": Scalar.UCHAR,
    "short": Scalar.SHORT,
    "short unsigned": Scalar.USHORT,
    "int": Scalar.INT,
    "unsigned": Scalar.UINT,
    "long": Scalar.LONG,
    "long unsigned": Scalar.ULONG,
    "long long": Scalar.LONG_LONG,
    "long long unsigned": Scalar.ULONG_LONG,
    "__int128": Scalar.INT128,
    "__int128 unsigned": Scalar.UINT128,
    "__int128_t": Scalar.INT128,
    "__uint128_t": Scalar.UINT128,
    "float": Scalar.FLOAT32,
    "double": Scalar.DOUBLE64,
}
_BUILT_IN = frozenset(
    ("__builtin_va_list", "va_list", "__int128", "__int128_t", "__uint128_t", *_NAMED)
)
_PLACE = re.compile(r"(?:.*:)?(\d+):(\d+)(?::\d+)?:?\s*(.*)", re.DOTALL)
_LARGE = 1 << 40
_Place = tuple[str, str, int, int]
"""File, text of the declaration, line and column of a struct or enum without a tag."""


class NotCError(Exception):
    """A declaration that is not valid C, with its line."""

    def __init__(self, message: str, line: int) -> None:
        super().__init__(message)
        self.message = message
        self.line = line


class _UnknownError(Exception):
    """A construct without counterpart in the model, or without a value at compile time."""


class Declarations:
    """Reads the declarations of C headers, one after the other, into one table.

    As in tecsgen, a header can use the typedefs and enumerators of headers imported before it.
    `enter` starts the next header.
    """

    def __init__(self) -> None:
        self._names: Mapping[str, str] = {}
        self._parser = CParser()
        self._typedefs: dict[str, CType] = {}
        self._values: dict[str, int] = {}
        self._declared: set[str] = set()
        self._untagged: dict[_Place, str] = {}
        self._titles: dict[_Place, str] = {}
        self._tags: dict[str, str] = {}
        self._taken: set[str] = set()
        self._file = ""
        self._line = 1
        self._text = ""
        self._declarations: list[TecsDeclaration] = []

    def enter(self, names: Mapping[str, str]) -> None:
        """Start a header; `names` maps the paths of its files to displayed names."""
        self._names = names
        self._declared.clear()

    def read(self, text: str, file: str, line: int) -> Iterator[TecsDeclaration]:
        """Yield the entities of a declaration. Raises NotCError."""
        self._file, self._line, self._text = file, line, text
        used = dict.fromkeys(re.findall(r"[A-Za-z_]\w*", text))
        typedefs = [
            name for name in used if name in self._typedefs or name in _BUILT_IN
        ]
        prefix = "".join(f"typedef int {name};" for name in typedefs)
        try:
            tree = self._parser.parse(f"{prefix}\n{text}")
        except ParseError as error:
            place = _PLACE.fullmatch(str(error))
            where = int(place[1]) - 2 if place else 0
            what = place[3] if place else str(error)
            raise NotCError(what or "this is not C", line + max(where, 0)) from None
        except (AssertionError, RecursionError) as error:
            raise NotCError("this is not understood", line) from error
        self._declarations = []
        nodes = tree.ext[len(typedefs) :]
        self._name_untagged(nodes)
        for node in nodes:
            self._declare(node)
        yield from self._declarations

    def _declare(self, node: Any) -> None:
        if isinstance(node, c_ast.Typedef):
            name = node.name
            try:
                type_ = self._type(node.type)
            except _UnknownError:
                type_ = opaque(name)
            if name in _NAMED:
                type_ = CScalarType(_NAMED[name])
            if depth(type_) > MAX_DEPTH:
                raise NotCError(f"'{name}' is nested too deeply", self._line)
            self._typedefs.setdefault(name, type_)
            if name not in self._declared and name not in RESERVED:
                self._declared.add(name)
                self._declarations.append(
                    TecsTypedef(
                        name=(name,),
                        file=self._names.get(self._file, self._file),
                        span=self._span(node.coord),
                        type=type_,
                        from_c=True,
                    )
                )
        elif isinstance(node, c_ast.Decl):
            try:
                self._type(node.type)
            except _UnknownError:
                return

    def _span(self, coord: Any) -> Span:
        line = self._line + max((coord.line or 2) - 2, 0) if coord else self._line
        column = (coord.column or 1) if coord else 1
        file = self._names.get(self._file, self._file)
        return Span(file, line, column, line, column + 1)

    def _type(self, node: Any) -> CType:
        if isinstance(node, c_ast.TypeDecl):
            return _qualified(self._specified(node.type), node.quals)
        if isinstance(node, c_ast.PtrDecl):
            return CPointerType(
                self._type(node.type), "const" in node.quals, "volatile" in node.quals
            )
        if isinstance(node, c_ast.ArrayDecl):
            size = None if node.dim is None else self._value(node.dim)
            if size is not None and size <= 0:
                size = None
            return CArrayType(self._type(node.type), size)
        if isinstance(node, c_ast.FuncDecl):
            parameters = node.args.params if node.args else ()
            return CFunctionType(
                self._type(node.type),
                tuple(
                    self._type(parameter.type)
                    for parameter in parameters
                    if not isinstance(parameter, c_ast.EllipsisParam | c_ast.ID)
                    and not _is_nothing(parameter.type)
                ),
            )
        return self._specified(node)

    def _specified(self, node: Any) -> CType:
        if isinstance(node, c_ast.IdentifierType):
            return self._named(node.names)
        if isinstance(node, c_ast.Struct):
            return self._struct(node)
        if isinstance(node, c_ast.Enum):
            return self._enum(node)
        raise _UnknownError

    def _named(self, names: list[str]) -> CType:
        if len(names) == 1 and names[0] in _NAMED:
            return CScalarType(_NAMED[names[0]])
        if len(names) == 1 and names[0] in self._typedefs:
            return CTypedefType((names[0],), self._typedefs[names[0]])
        words = sorted(names)
        if "int" in words and len(words) > 1:
            words.remove("int")
        if "signed" in words and words != ["char", "signed"]:
            words.remove("signed")
        kind = _BASIC.get(" ".join(words) or "int")
        if kind is None:
            raise _UnknownError
        return CScalarType(kind, plain="char" in words)

    def _struct(self, node: Any) -> CType:
        tag = self._tag(node)
        if node.decls is None:
            return CStructType((tag,))
        self._name_untagged(node.decls, f"{tag}_")
        members = []
        for member in node.decls:
            if not isinstance(member, c_ast.Decl):
                continue
            if member.name is None:  # an anonymous nested struct, or padding
                if isinstance(member.type, c_ast.Struct) and member.type.decls:
                    raise _UnknownError
                continue
            try:
                type_ = self._type(member.type)
            except _UnknownError:
                type_ = opaque(f"{tag}.{member.name}")
            members.append(
                TecsMember(name=member.name, type=type_, span=self._span(member.coord))
            )
        self._declarations.append(
            TecsStruct(
                name=(tag,),
                file=self._names.get(self._file, self._file),
                span=self._span(node.coord),
                members=tuple(members),
                from_c=True,
            )
        )
        return CStructType((tag,))

    def _enum(self, node: Any) -> CType:
        tag = self._tag(node)
        if node.values is None:
            return CEnumType((tag,))
        members = []
        value = -1
        for enumerator in node.values.enumerators:
            value = (
                value + 1 if enumerator.value is None else self._value(enumerator.value)
            )
            self._values[enumerator.name] = value
            members.append((enumerator.name, value))
        self._declarations.append(
            TecsEnum(
                name=(tag,),
                file=self._names.get(self._file, self._file),
                span=self._span(node.coord),
                members=tuple(members),
            )
        )
        return CEnumType((tag,))

    def _name_untagged(self, nodes: Iterable[Any], prefix: str = "") -> None:
        """Choose the names of structs and enums without a tag, from what is declared with them.

        It is that of the first declarator of the type itself, as in C++; if all are pointers or
        arrays, the first one's, of a typedef with `_type`, since it needs the name itself.
        """
        titles: dict[_Place, tuple[bool, str]] = {}
        for node in nodes:
            if not isinstance(node, c_ast.Typedef | c_ast.Decl) or not node.name:
                continue
            inner = node.type
            plain = isinstance(inner, c_ast.TypeDecl)
            while isinstance(inner, c_ast.PtrDecl | c_ast.ArrayDecl | c_ast.FuncDecl):
                inner = inner.type
            specified = getattr(inner, "type", None)
            if isinstance(specified, c_ast.Struct | c_ast.Enum) and not specified.name:
                alone = isinstance(node, c_ast.Typedef) and not plain
                title = f"{prefix}{node.name}{'_type' * alone}"
                first = titles.setdefault(self._place(specified), (plain, title))
                if plain and not first[0]:
                    titles[self._place(specified)] = (plain, title)
        self._titles.update({place: title for place, (_, title) in titles.items()})

    def _tag(self, node: Any) -> str:
        """Return the name of a struct or enum: its tag, or one that no other has."""
        if node.name:
            name = self._tags.get(node.name)
            if name is None:
                name = self._tags[node.name] = self._free(node.name)
            return name
        place = self._place(node)
        name = self._untagged.get(place)
        if name is None:
            name = self._free(self._titles.get(place, "untagged"))
            self._untagged[place] = name
        return name

    def _free(self, name: str) -> str:
        while name in self._taken:
            name += "_"
        self._taken.add(name)
        return name

    def _place(self, node: Any) -> _Place:
        span = self._span(node.coord)
        return (self._file, self._text, span.line, span.column)

    def _value(self, node: Any) -> int:
        """Return the value of a constant expression. Raises _UnknownError."""
        if isinstance(node, c_ast.Constant):
            return _constant(node.value)
        if isinstance(node, c_ast.ID) and node.name in self._values:
            return self._values[node.name]
        if isinstance(node, c_ast.Cast):
            return self._value(node.expr)
        if isinstance(node, c_ast.TernaryOp):
            return self._value(node.iftrue if self._value(node.cond) else node.iffalse)
        if isinstance(node, c_ast.UnaryOp) and node.op in ("-", "+", "~", "!"):
            value = self._value(node.expr)
            return {"-": -value, "+": value, "~": ~value, "!": int(not value)}[node.op]
        if isinstance(node, c_ast.BinaryOp):
            return _computed(node.op, self._value(node.left), self._value(node.right))
        raise _UnknownError


def _computed(mark: str, one: int, two: int) -> int:
    if abs(one) > _LARGE or abs(two) > _LARGE:
        raise _UnknownError
    if mark in ("/", "%"):
        if two == 0:
            raise _UnknownError
        quotient = abs(one) // abs(two) * (1 if (one < 0) == (two < 0) else -1)
        return quotient if mark == "/" else one - quotient * two
    if mark in ("<<", ">>"):
        if not 0 <= two < 64:
            raise _UnknownError
        return one << two if mark == "<<" else one >> two
    table = {
        "+": one + two,
        "-": one - two,
        "*": one * two,
        "&": one & two,
        "|": one | two,
        "^": one ^ two,
        "&&": int(bool(one and two)),
        "||": int(bool(one or two)),
        "==": int(one == two),
        "!=": int(one != two),
        "<": int(one < two),
        ">": int(one > two),
        "<=": int(one <= two),
        ">=": int(one >= two),
    }
    if mark not in table:
        raise _UnknownError
    return table[mark]


def _constant(text: str) -> int:
    if text.startswith("'") and len(text) == 3:
        return ord(text[1])
    digits = text.rstrip("uUlL")
    try:
        if digits[:1] == "0" and digits[1:].isdigit():
            return int(digits, 8)
        return int(digits, 0)
    except ValueError:
        raise _UnknownError from None


def _qualified(type_: CType, words: list[str]) -> CType:
    if not words or isinstance(type_, CArrayType | CFunctionType | CPointerType):
        return type_
    assert isinstance(type_, CScalarType | CTypedefType | CStructType | CEnumType)
    return replace(
        type_,
        const=type_.const or "const" in words,
        volatile=type_.volatile or "volatile" in words,
    )


def _is_nothing(node: Any) -> bool:
    """Return whether it is the `void` of a function without parameters."""
    return (
        isinstance(node, c_ast.TypeDecl)
        and isinstance(node.type, c_ast.IdentifierType)
        and node.type.names == ["void"]
    )
