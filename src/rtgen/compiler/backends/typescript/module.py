"""The text of one module: the declarations of an IDL file, in their order."""

from __future__ import annotations

import re
from collections.abc import Callable, Sequence
from typing import Any

from rtgen.compiler.backends.kit.member_texts import member_text
from rtgen.compiler.backends.kit.quoting import typescript as quoting
from rtgen.compiler.backends.kit.quoting.typescript import TypeScript
from rtgen.compiler.backends.kit.rendering import render
from rtgen.compiler.backends.typescript.types import Types, identifier
from rtgen.compiler.model import (
    Bitmask,
    Case,
    Const,
    ConstantValue,
    Declaration,
    Enum,
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

_WORD = re.compile(r"[A-Za-z0-9_$]+")
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

    def text(self, header: TypeScript, declarations: Sequence[Declaration]) -> str:
        """Return the module's text."""
        parts = [self._declaration(each) for each in declarations]
        return render(
            "typescript/types.ts.j2",
            header=header,
            runtime=[name for name in _RUNTIME if name in self._words],
            imports=sorted(self._imported.items()),
            declarations=parts,
        )

    def _declaration(self, declaration: Declaration) -> dict[str, Any]:
        """Return the values for the template."""
        part = {
            "name": identifier(declaration.name),
            "doc": member_text(declaration),
            "scoped": declaration.scoped,
            **self._values(declaration),
        }
        self._done.add(declaration.name)
        return part

    def _values(self, declaration: Declaration) -> dict[str, Any]:
        match declaration:
            case Struct():
                members = self._model.members(declaration)
                appendable = self._types.is_appendable(declaration)
                return self._struct(members, appendable)
            case ExceptionDecl(members=members):
                return self._struct(members, False)
            case Union():
                return self._union(declaration)
            case Enum():
                return self._enum(declaration)
            case Bitmask():
                return self._bitmask(declaration)
            case Typedef():
                return self._typedef(declaration)
            case Const(type=type_, value=value):
                return {"kind": "constant", "value": self._literal(type_, value)}
        raise AssertionError(f"{declaration.scoped} was reported")

    def _struct(self, members: Sequence[Member], appendable: bool) -> dict[str, Any]:
        self._words.update(("CdrType", "struct", *(["field"] if members else ())))
        return {
            "kind": "struct",
            "appendable": appendable,
            "members": [
                {
                    "name": member.name,
                    "text": member_text(member),
                    "type": self._value(member.type),
                    "codec": self._codec(member.type),
                    "initial": self._types.initial(member.type, member.initial),
                    "optional": member.optional,
                }
                for member in members
            ],
        }

    def _union(self, union: Union) -> dict[str, Any]:
        self._words.update(("CdrType", "union", *(["branch"] if union.cases else ())))
        return {
            "kind": "union",
            "appendable": self._types.is_appendable(union),
            "switch": self._value(union.switch),
            "codec": self._codec(union.switch),
            "complete": self._is_complete(union),
            "cases": [self._case(union, case) for case in union.cases],
        }

    def _case(self, union: Union, case: Case) -> dict[str, Any]:
        labels = (self._literal(union.switch, each) for each in case.labels)
        return {
            "name": case.name,
            "text": member_text(case),
            "type": self._value(case.type),
            "codec": self._codec(case.type),
            "labels": [TypeScript(label) for label in labels],
            "is_default": case.default,
            "initial": self._types.initial(case.type, case.initial),
        }

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

    def _enum(self, enum: Enum) -> dict[str, Any]:
        self._words.update(("CdrType", "enumeration"))
        is_first = enum.initial is enum.members[0]
        return {
            "kind": "enum",
            "members": enum.members,
            "bound": None if is_first and enum.bound == 32 else enum.bound,
            "initial": None if is_first else enum.initial.name,
        }

    def _bitmask(self, mask: Bitmask) -> dict[str, Any]:
        big = mask.bound > 32
        self._words.update(("CdrType", "bitmask64" if big else "bitmask"))
        return {
            "kind": "bitmask",
            "big": big,
            "bound": mask.bound,
            "flags": [
                {
                    "name": identifier((*mask.name, flag.name)),
                    "doc": flag.doc,
                    "value": quoting.constant(1 << flag.value, is_64_bit=big),
                }
                for flag in mask.members
            ],
        }

    def _typedef(self, typedef: Typedef) -> dict[str, Any]:
        codec = self._codec(typedef.type)
        initial = self._types.initial(typedef.type, typedef.initial)
        self._words.update(("CdrType", *(["initially"] if initial is not None else ())))
        value = self._value(typedef.type)
        return {"kind": "typedef", "type": value, "codec": codec, "initial": initial}

    def _literal(self, type_: Type, value: ConstantValue) -> str:
        return self._types.literal(self._model.unalias(type_), value)

    def _value(self, type_: Type) -> str:
        self._types.codec(type_, self._refer)
        return self._types.value(type_)

    def _codec(self, type_: Type) -> str:
        codec = self._types.codec(type_, self._refer)
        self._words.update(_WORD.findall(_STRING.sub("", codec)))
        return codec

    @property
    def _refer(self) -> Callable[[ScopedName], bool]:
        def refer(name: ScopedName) -> bool:
            module = self._places[name]
            if module == self._module:
                return name in self._done
            self._imported.setdefault(module, {})[identifier(name)] = None
            return True

        return refer
