"""The model: a frozen value for everything that was read, common to all input languages."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from functools import cached_property
from typing import TYPE_CHECKING, TypeVar

import msgspec

from rtgen.compiler.model.components import (
    Activation,
    Adapter,
    Component,
    ConfigurationParameter,
    Connection,
    Port,
    PortKind,
    PortReference,
    System,
    SystemComponent,
)
from rtgen.compiler.model.declarations import (
    Annotation,
    Attribute,
    Bitfield,
    Bitmask,
    Bitset,
    Case,
    Const,
    ConstantValue,
    Declaration,
    Direction,
    Documented,
    Enum,
    Enumerator,
    EnumeratorName,
    ExceptionDecl,
    Extensibility,
    Home,
    InitialValue,
    Interface,
    Limits,
    Member,
    Native,
    Operation,
    Parameter,
    StateMember,
    Struct,
    Typedef,
    Union,
    ValueBox,
    Valuetype,
    limits,
)
from rtgen.compiler.model.types import (
    VOID,
    ArrayType,
    FixedType,
    MapType,
    NamedType,
    PrimitiveType,
    ScopedName,
    SequenceType,
    StringType,
    Type,
    default_id,
)
from rtgen.facts.primitives import Primitive

if TYPE_CHECKING:  # imported lazily: many classes, which most commands do not need
    from rtgen.compiler.model.can_bus import Bus
    from rtgen.compiler.model.canopen import Device
    from rtgen.compiler.model.rtc_profile import RtcProfile
    from rtgen.compiler.model.tecs import TecsUnit

_Derived = TypeVar("_Derived", Struct, Bitset)

__all__ = [
    "VOID",
    "Activation",
    "Adapter",
    "Annotation",
    "ArrayType",
    "Attribute",
    "Bitfield",
    "Bitmask",
    "Bitset",
    "Case",
    "Component",
    "ConfigurationParameter",
    "Connection",
    "Const",
    "ConstantValue",
    "Declaration",
    "Direction",
    "Documented",
    "Enum",
    "Enumerator",
    "EnumeratorName",
    "ExceptionDecl",
    "Extensibility",
    "FixedType",
    "Home",
    "InitialValue",
    "Interface",
    "Limits",
    "MapType",
    "Member",
    "Model",
    "NamedType",
    "Native",
    "Operation",
    "Package",
    "Parameter",
    "Port",
    "PortKind",
    "PortReference",
    "Primitive",
    "PrimitiveType",
    "ScopedName",
    "SequenceType",
    "SourceFile",
    "StateMember",
    "StringType",
    "Struct",
    "System",
    "SystemComponent",
    "Type",
    "Typedef",
    "Union",
    "ValueBox",
    "Valuetype",
    "default_id",
    "limits",
]


class SourceFile(msgspec.Struct, frozen=True, kw_only=True):
    """A file that was read.

    `name` is the displayed path (as in spans), `key` the path for generated text (relative to the
    project or to the include folder, never absolute), `sha256` the hash of its content. `includes`
    are the names of directly included files, in order. `main`: the file was given, not only
    included. A file that is included inside a scope has its includer in `belongs_to`.

    Lowerings set where back ends find the file's declarations: `package` is their Python package,
    if that is not the generated one, `module` the module there, if the file has none of its own,
    and `taken` the other names bound in that module. `exported`: the generated package exports the
    declarations under the names of the IDL modules.
    """

    name: str
    key: str
    sha256: str
    main: bool
    includes: tuple[str, ...] = ()
    belongs_to: str | None = None
    package: str = ""
    module: str = ""
    taken: frozenset[str] = frozenset()
    exported: bool = True


class Model(msgspec.Struct, frozen=True, dict=True):
    """Everything that was read: files (included before includer) and declarations in order.

    Each main CDL file is a separate unit in `tecs`; see `model.tecs`. `packages` are made
    by lowerings.
    """

    files: tuple[SourceFile, ...] = ()
    declarations: tuple[Declaration, ...] = ()
    systems: tuple[System, ...] = ()
    tecs: tuple[TecsUnit, ...] = ()
    devices: tuple[Device, ...] = ()
    buses: tuple[Bus, ...] = ()
    profiles: tuple[RtcProfile, ...] = ()
    adapters: tuple[Adapter, ...] = ()
    packages: tuple[Package, ...] = ()

    @cached_property
    def _by_name(self) -> dict[ScopedName, Declaration]:
        return {d.name: d for d in self.declarations}

    def find(self, name: ScopedName) -> Declaration:
        """Find a declaration by scoped name. Raises KeyError."""
        return self._by_name[name]

    def declared(self, type_: Type) -> Declaration | None:
        """Return what a type names, with typedefs resolved; None for types without a name."""
        plain = self.unalias(type_)
        return self._by_name[plain.name] if isinstance(plain, NamedType) else None

    def lineage(self, derived: _Derived) -> list[_Derived]:
        """Return a struct or bitset after its bases."""
        line = [derived]
        while (name := line[0].base) is not None:
            base = self._by_name[name]
            assert isinstance(base, type(derived)), "the front end saw to it"
            line.insert(0, base)
        return line

    def members(self, struct: Struct) -> list[Member]:
        """Return the members of a struct, inherited ones first."""
        return [member for each in self.lineage(struct) for member in each.members]

    def bases(self, declaration: Interface | Valuetype) -> list[Interface | Valuetype]:
        """Return all direct and indirect bases, each once and after its own bases."""
        ancestors: dict[ScopedName, Interface | Valuetype] = {}
        waiting = [*reversed(declaration.bases)]
        while waiting:
            name = waiting[-1]
            base = self._by_name[name]
            assert isinstance(base, Interface | Valuetype), "the front end saw to it"
            missing = [each for each in reversed(base.bases) if each not in ancestors]
            if missing:
                waiting += missing
            else:
                ancestors.setdefault(name, base)
                waiting.pop()
        return [*ancestors.values()]

    def unalias(self, type_: Type) -> Type:
        """Return the type with typedefs resolved; never a NamedType that refers to a Typedef."""
        while isinstance(type_, NamedType):
            declaration = self._by_name[type_.name]
            if not isinstance(declaration, Typedef):
                return type_
            type_ = declaration.type
        return type_

    def typedef(self, type_: Type) -> Typedef | None:
        """Return the typedef that a type names; None for other types."""
        declaration = (
            self._by_name.get(type_.name) if isinstance(type_, NamedType) else None
        )
        return declaration if isinstance(declaration, Typedef) else None

    @cached_property
    def _enumerators(self) -> dict[ScopedName, Enumerator]:
        enums = [each for each in self.declarations if isinstance(each, Enum)]
        return {(*d.name[:-1], m.name): m for d in enums for m in d.members}

    def enumerator(self, name: ScopedName) -> Enumerator:
        """Find an enumerator by its scoped name. Raises KeyError."""
        return self._enumerators[name]

    @cached_property
    def _by_file(self) -> dict[str, list[Declaration]]:
        files: dict[str, list[Declaration]] = {}
        for declaration in self.declarations:
            files.setdefault(declaration.file, []).append(declaration)
        return files

    def of_file(self, name: str) -> Sequence[Declaration]:
        """Return the declarations in a file, by its displayed path."""
        return self._by_file.get(name, ())


class Package(msgspec.Struct, frozen=True, kw_only=True):
    """Declarations that are generated in a package `name` below the project's.

    `sources` are the files that the package depends on. `any_values`: values of the types are sent
    in an `any`. `profiles` maps names of components to the paths of their profiles in the package's
    folder; other profiles are beside their components.
    """

    name: str
    model: Model
    sources: tuple[SourceFile, ...]
    any_values: bool = False
    profiles: Mapping[str, str] = msgspec.field(default_factory=dict)
