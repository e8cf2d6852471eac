"""The text of one module: the declarations of an IDL file, in their order."""

from __future__ import annotations

import re
from collections.abc import Callable, Iterable, Iterator, Sequence

from rtgen.compiler.backends.typescript import quoting
from rtgen.compiler.backends.typescript.types import Types, identifier
from rtgen.compiler.model import (
    Bitmask,
    Case,
    Const,
    ConstantValue,
    Declaration,
    Enum,
    Enumerator,
    ExceptionDecl,
    Member,
    Model,
    Primitive,
    PrimitiveType,
    ScopedName,
    Struct,
    Type,
    Typedef,
    Union,
)
from rtgen.compiler.typemap.member_units import member_text

_CODEC_WORD = re.compile(r"[A-Za-z0-9_$]+")
_STRING = re.compile(r'"(?:[^"\\]|\\.)*"')
_RUNTIME = (
    *("CdrType", "array", "bitmask", "bitmask64", "boolean", "branch", "char"),
    *("chars", "double", "enumeration", "field", "float", "initially", "int8"),
    *("lazy", "long", "longlong", "map", "octet", "octets", "sequence", "short"),
    *("string", "struct", "ulong", "ulonglong", "union", "ushort", "wchar"),
    "wstring",
)


_BOOLEAN = PrimitiveType(Primitive.BOOLEAN)


class TypesModule:
    """Builds one module. `places` has the module of each declaration."""

    def __init__(
        self, model: Model, types: Types, places: dict[ScopedName, str], module: str
    ) -> None:
        self._model = model
        self._types = types
        self._places = places
        self._module = module
        self._done: set[ScopedName] = set()
        self._imported: dict[str, dict[str, None]] = {}
        self._words: set[str] = set()
        """Words in codecs, including names of the runtime."""

    def text(self, header: str, declarations: Sequence[Declaration]) -> str:
        """Return the module's text."""
        blocks = ["\n".join(self._block(each)) for each in declarations]
        body = "\n\n".join(block for block in blocks if block)
        used = [name for name in _RUNTIME if name in self._words]
        names = ", ".join(f"type {n}" if n == "CdrType" else n for n in used)
        imports = [f'import {{ {names} }} from "../_cdr.ts";'] if used else []
        for module, imported in sorted(self._imported.items()):
            imports.append(f'import {{ {", ".join(imported)} }} from "./{module}.ts";')
        parts = [header, "\n".join(imports), body or "export {};"]
        return "\n\n".join(part for part in parts if part) + "\n"

    def _block(self, declaration: Declaration) -> Iterator[str]:
        name = identifier(declaration.name)
        match declaration:
            case Struct():
                appendable = self._types.is_appendable(declaration)
                members = self._model.members(declaration)
                yield from self._struct(declaration, members, appendable)
            case ExceptionDecl(members=members):
                yield from self._struct(declaration, members, False)
            case Union():
                yield from self._union(declaration)
            case Enum():
                yield from self._enum(declaration)
            case Bitmask():
                yield from self._bitmask(declaration)
            case Typedef(type=type_):
                yield from quoting.comment(declaration.doc)
                yield f"export type {name} = {self._value(type_)};"
                codec = self._codec(type_)
                initial = self._types.initial(type_, declaration.initial)
                if initial is not None:
                    codec = f"initially({codec}, () => {initial})"
                yield self._constant(name, codec)
            case Const(type=type_, value=value):
                yield from quoting.comment(declaration.doc)
                yield f"export const {name} = {self._literal(type_, value)};"
        self._done.add(declaration.name)

    def _struct(
        self, declaration: Declaration, members: Sequence[Member], appendable: bool
    ) -> Iterator[str]:
        name = identifier(declaration.name)
        yield from quoting.comment(declaration.doc)
        yield f"export interface {name} {{"
        for member in members:
            yield from quoting.comment(member_text(member), "  ")
            absent = " | null" if member.optional else ""
            yield f"  {_property(member.name)}: {self._value(member.type)}{absent};"
        yield "}"
        fields = [self._field(member) for member in members]
        scoped = quoting.string(declaration.scoped)
        yield self._constant(name, _call("struct", scoped, fields, appendable))

    def _field(self, member: Member) -> str:
        codec = self._codec(member.type)
        initial = self._types.initial(member.type, member.initial)
        more = ", true" * member.optional
        if initial is not None and not member.optional:
            more = f", false, () => {initial}"
        return f"field({quoting.string(member.name)}, {codec}{more})"

    def _union(self, union: Union) -> Iterator[str]:
        name = identifier(union.name)
        switch = self._value(union.switch)
        yield from quoting.comment(union.doc)
        yield f"export type {name} ="
        for case in union.cases:
            yield from quoting.comment(member_text(case), "  ")
            label = quoting.string(case.name)
            value = self._value(case.type)
            # The discriminator defaults to the first label of the branch; without labels it is
            # required.
            mark = "" if not case.labels else "?"
            yield f"  | {{ case: {label}; value: {value}; discriminator{mark}: {switch} }}"
        if not self._is_complete(union):
            yield f"  | {{ case: null; discriminator: {switch} }}"
        yield "  ;"
        branches = [self._branch(union, case) for case in union.cases]
        inner = f"{quoting.string(union.scoped)}, {self._codec(union.switch)}"
        appendable = self._types.is_appendable(union)
        yield self._constant(name, _call("union", inner, branches, appendable))

    def _is_complete(self, union: Union) -> bool:
        """Return whether each discriminator selects a branch."""
        if any(case.default for case in union.cases):
            return True
        count = sum(len(case.labels) for case in union.cases)
        declared = self._model.declared(union.switch)
        if isinstance(declared, Enum):
            return count == len(declared.members)
        is_boolean = self._model.unalias(union.switch) == _BOOLEAN
        return is_boolean and count == 2

    def _branch(self, union: Union, case: Case) -> str:
        labels = ", ".join(self._literal(union.switch, each) for each in case.labels)
        default = ", true" if case.default else ""
        initial = self._types.initial(case.type, case.initial)
        if initial is not None:
            default = f", {str(case.default).lower()}, () => {initial}"
        codec = self._codec(case.type)
        return f"branch({quoting.string(case.name)}, {codec}, [{labels}]{default})"

    def _enum(self, enum: Enum) -> Iterator[str]:
        name = identifier(enum.name)
        yield from quoting.comment(enum.doc)
        values = " | ".join(quoting.string(each.name) for each in enum.members)
        yield f"export type {name} = {values};"
        numbers = ", ".join(
            f"{_property(each.name)}: {each.value}" for each in enum.members
        )
        bits = f", {enum.bound}" if enum.bound != 32 else ""
        if enum.initial is not enum.members[0]:
            bits = f", {enum.bound}, {quoting.string(enum.initial.name)}"
        scoped = quoting.string(enum.scoped)
        yield self._constant(name, f"enumeration({scoped}, {{ {numbers} }}{bits})")

    def _bitmask(self, mask: Bitmask) -> Iterator[str]:
        name, big = identifier(mask.name), mask.bound > 32
        scoped = quoting.string(mask.scoped)
        yield from quoting.comment(mask.doc)
        yield f"export type {name} = {'bigint' if big else 'number'};"
        bits = f"bitmask64({scoped})" if big else f"bitmask({scoped}, {mask.bound})"
        yield self._constant(name, bits)
        yield from self._flags(mask.name, mask.members, big)

    def _flags(
        self, name: ScopedName, members: Iterable[Enumerator], big: bool
    ) -> Iterator[str]:
        for each in members:
            yield from quoting.comment(each.doc)
            value = f"{1 << each.value}{'n' if big else ''}"
            yield f"export const {identifier((*name, each.name))} = {value};"

    def _constant(self, name: str, codec: str) -> str:
        self._words.update(["CdrType", *_CODEC_WORD.findall(_STRING.sub("", codec))])
        return f"export const {name}: CdrType<{name}> = {codec};"

    def _literal(self, type_: Type, value: ConstantValue) -> str:
        return self._types.literal(self._model.unalias(type_), value)

    def _value(self, type_: Type) -> str:
        self._types.codec(type_, self._refer)
        return self._types.value(type_)

    def _codec(self, type_: Type) -> str:
        return self._types.codec(type_, self._refer)

    @property
    def _refer(self) -> Callable[[ScopedName], bool]:
        def refer(name: ScopedName) -> bool:
            module = self._places[name]
            if module == self._module:
                return name in self._done
            self._imported.setdefault(module, {})[identifier(name)] = None
            return True

        return refer


def _call(function: str, inner: str, parts: Sequence[str], appendable: bool) -> str:
    lines = "".join(f"\n  {part}," for part in parts)
    body = f"[{lines}\n]" if parts else "[]"
    return f"{function}({inner}, {body}{', true' if appendable else ''})"


def _property(name: str) -> str:
    return name if _CODEC_WORD.fullmatch(name) else quoting.string(name)
