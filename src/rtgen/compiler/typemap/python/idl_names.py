"""IDL to Python: names and modules of declarations and members.

A name that Python, a generated class or generated text already uses gets a trailing `_` (OMG IDL to
Python mapping 1.3 prepends one).
"""

from __future__ import annotations

import builtins
from collections import Counter
from collections.abc import Collection, Iterable, Iterator, Sequence
from functools import cached_property, lru_cache
from typing import TypeAlias

from rtgen.compiler.kit.words import words
from rtgen.compiler.model import (
    Bitfield,
    Bitmask,
    Bitset,
    Case,
    Declaration,
    Enum,
    ExceptionDecl,
    Home,
    Interface,
    Member,
    Model,
    Native,
    ScopedName,
    Struct,
    Typedef,
    Union,
    ValueBox,
    Valuetype,
)
from rtgen.compiler.model.components import Component
from rtgen.compiler.typemap.python.implementation_modules import (
    implementation_modules,
    referred,
)
from rtgen.compiler.typemap.python.names import identifier
from rtgen.compiler.typemap.python.support import HOMES

CODEC = words("to_cdr from_cdr to_xcdr1 from_xcdr1 to_xcdr2 from_xcdr2 key_hash")
"""Public methods of all types with a codec; equal IDL names get a trailing `_`."""

NUMBER = frozenset({"to_number", "from_number"})
"""Further methods of types that are one number on the wire."""

_UNION_FIELDS = frozenset({"discriminator", "value"})

OWN_NAMES: dict[type[Declaration], frozenset[str]] = {
    Struct: CODEC,
    ExceptionDecl: CODEC | {"args", "with_traceback", "add_note"},
    Union: CODEC | _UNION_FIELDS,
    Enum: CODEC | NUMBER | words("""
        name value mro as_integer_ratio bit_count bit_length conjugate denominator from_bytes imag
        is_integer numerator real to_bytes
        """),
}
"""Attributes of the Python class of a declaration, which members cannot use."""
OWN_NAMES[Bitmask] = OWN_NAMES[Enum]
OWN_NAMES[Bitset] = CODEC | NUMBER
OWN_NAMES[Valuetype] = CODEC | {"described"}

_ARGUMENTS = frozenset({"self", "cls"})
"""First arguments of methods, whose bodies refer to classes."""

_FUTURE = frozenset({"annotations"})
"""Names that implementation modules import from `__future__`."""

COMPANIONS = ("Stub", "Skeleton", "Codec")
"""Suffixes of the names of further classes of a declaration."""

_PACKAGES = frozenset({"components", "tecs"})
"""Packages below the root that rtgen itself generates."""

Fielded: TypeAlias = Struct | ExceptionDecl | Union | Bitset | Valuetype
"""Declarations whose parts become attributes."""


class PythonNames:
    """The place of each declaration of a model in the generated package, or in another one.

    There is one implementation module for each IDL file, `_idl.<file>`, unless the file has a
    module of its own, and one package for each IDL module, which re-exports.
    """

    def __init__(self, model: Model, package: str) -> None:
        self.package = package
        self._model = model
        self._modules = implementation_modules(model)
        self._files = {file.name: file for file in model.files}
        self._homes = self._chosen_homes()
        self._implementations: dict[ScopedName, tuple[str, str]] = {}
        self._depths: dict[ScopedName, int] = {(): 0}
        self._attributes: dict[str, frozenset[str]] = {}
        self._holdings: dict[ScopedName, dict[str, Declaration]] = {}
        self._operations: dict[ScopedName, dict[str, str]] = {}
        self._members: dict[ScopedName, dict[str, str]] = {}
        self._members_by_names: dict[object, dict[str, str]] = {}
        for module in dict.fromkeys(self._modules.values()):
            self._name_classes(module)

    def module(self, file: str) -> str:
        """Return the implementation module of a source file, given by displayed path."""
        return self._modules[file]

    def home(self, module: str) -> str:
        """Return the absolute name of the Python module with an implementation module."""
        return self._homes[module]

    def is_own(self, name: ScopedName) -> bool:
        """Return whether the declaration is in the generated package, not in another one."""
        return not self._files[self._model.find(name).file].package

    def _chosen_homes(self) -> dict[str, str]:
        homes: dict[str, str] = {}
        for module, names in self._files_of.items():
            files = [self._files[name] for name in names]
            chosen = {file.module for file in files}
            inside = chosen.pop() if len(chosen) == 1 else ""
            package = files[0].package or self.package
            homes[module] = f"{package}.{inside or f'_idl.{module}'}"
        return homes

    def taken_in(self, module: str) -> frozenset[str]:
        """Return names bound in an implementation module besides those of declarations."""
        files = (self._files[name] for name in self._files_of[module])
        return frozenset().union(*(file.taken for file in files))

    @cached_property
    def _files_of(self) -> dict[str, list[str]]:
        """The files of each implementation module, without those that belong to others."""
        files: dict[str, list[str]] = {}
        for name, module in self._modules.items():
            if self._files[name].belongs_to is None:
                files.setdefault(module, []).append(name)
        return files

    def declarations(self, module: str) -> list[Declaration]:
        """Return the declarations in an implementation module, in order."""
        return self._by_module.get(module, [])

    def inside(self, scope: ScopedName) -> list[Declaration]:
        """Return the declarations directly in a scope, in order."""
        return self._by_scope.get(scope, [])

    @property
    def modules(self) -> list[str]:
        """All nonempty implementation modules, in order of the files."""
        used = self._by_module
        return [m for m in dict.fromkeys(self._modules.values()) if m in used]

    def implementation(self, name: ScopedName) -> tuple[str, str]:
        """Return (absolute name of the module, class name) of a declaration."""
        return self._implementations[name]

    def public(self, name: ScopedName) -> tuple[tuple[str, ...], str]:
        """Return (package path below the root, attribute there) of a declaration.

        `("IIS", "TimedPose2D")` gives `(("iis",), "TimedPose2D")`, a declaration in the global
        scope `((), "RefHard")`, a type in an interface `((), "RefHard.Mode")`.
        """
        inner = self._depth(name)
        attribute = ".".join(
            self._attribute(name[: i + 1]) for i in range(inner, len(name))
        )
        return package_path(name[:inner]), attribute

    def public_package(self, name: ScopedName) -> str:
        """Return the absolute name of the package to which the path of `public` is relative."""
        file = self._files[self._model.find(name).file]
        return self.package if file.exported or not file.package else file.package

    def attribute(self, name: ScopedName) -> str:
        """Return the attribute of a declaration or enumerator in its enclosing scope."""
        return self._attribute(name)

    def companion(self, name: ScopedName, suffix: str) -> str:
        """Return the companion of a declaration's class: `RefHardStub`, `RangeListCodec`."""
        taken = self._taken_of[self._modules[self._model.find(name).file]]
        return _free(self._implementations[name][1] + suffix, taken)

    def public_companion(self, name: ScopedName, suffix: str) -> str:
        """Return the name of a companion in the package of the declaration's IDL module."""
        return _free(self._attribute(name) + suffix, self._members_of[name[:-1]])

    @cached_property
    def _taken_of(self) -> dict[str, frozenset[str]]:
        """The names of the classes in each implementation module, and others bound there."""
        return {
            module: self.taken_in(module).union(
                self._implementations[d.name][1] for d in declarations
            )
            for module, declarations in self._by_module.items()
        }

    @cached_property
    def _members_of(self) -> dict[ScopedName, set[str]]:
        """The names that each scope declares."""
        members: dict[ScopedName, set[str]] = {}
        for declaration in self._model.declarations:
            *scope, name = declaration.name
            members.setdefault(tuple(scope), set()).add(name)
        return members

    def is_nested(self, name: ScopedName) -> bool:
        """Return whether a declaration is inside an interface, struct or similar."""
        return self._depth(name) < len(name) - 1

    def enumerator(self, name: ScopedName) -> tuple[ScopedName, str]:
        """Return the enum of an enumerator's scoped name, and its Python name there."""
        enum = self._model.find(self._enumerators[name])
        assert isinstance(enum, Enum | Bitmask)
        return enum.name, self.enumerators(enum)[name[-1]]

    def enumerators(self, declaration: Enum | Bitmask) -> dict[str, str]:
        """Return the Python names of the members of an enum or bitmask."""
        return distinct((m.name for m in declaration.members), OWN_NAMES[Enum])

    def enumerators_of(self, name: ScopedName) -> list[str]:
        """Return the Python names of the enumerators of an enum, in order."""
        declaration = self._model.find(name)
        assert isinstance(declaration, Enum)
        return list(self.enumerators(declaration).values())

    def members(self, declaration: Fielded) -> dict[str, str]:
        """Return the Python names of a struct's members, or of a union's branches."""
        name = declaration.name
        if name not in self._members:
            self._members[name] = self._new_members(declaration)
        return self._members[name]

    def _new_members(self, declaration: Fielded) -> dict[str, str]:
        inherited: list[str] = []
        entries: Sequence[Member | Case | Bitfield]
        if isinstance(declaration, Union):
            entries = declaration.cases
        elif isinstance(declaration, Valuetype):
            entries = declaration.state
            inherited = self._inherited_state(declaration)
            nested = self.inside(declaration.name)
            inherited += [self._attribute(inner.name) for inner in nested]
        else:
            entries = declaration.members
            if isinstance(declaration, Struct | Bitset) and declaration.base:
                base = self._model.find(declaration.base)
                assert isinstance(base, Struct | Bitset)
                inherited = list(self.members(base).values())
        parts = tuple([e.name for e in entries if e.name])
        key = type(declaration), parts, *inherited
        names = self._members_by_names.get(key)
        if names is None:
            own = OWN_NAMES[type(declaration)].union(inherited)
            names = self._members_by_names[key] = distinct(parts, own)
        return names

    def operations(self, declaration: Interface | Valuetype) -> dict[str, str]:
        """Return the Python names of the attributes and operations added to the bases'."""
        name = declaration.name
        if name not in self._operations:
            self._operations[name] = self._new_operations(declaration)
        return self._operations[name]

    def _new_operations(self, declaration: Interface | Valuetype) -> dict[str, str]:
        taken = {self._attribute(inner.name) for inner in self.inside(declaration.name)}
        for base in self._model.bases(declaration):
            taken.update(self.operations(base).values())
        if isinstance(declaration, Valuetype):
            taken.update(OWN_NAMES[Valuetype], self.members(declaration).values())
            taken.update(self._inherited_state(declaration))
        attributes = [attribute.name for attribute in declaration.attributes]
        operations = [operation.name for operation in declaration.operations]
        return distinct(attributes + operations, taken)

    def bases(self, declaration: Interface | Valuetype) -> list[ScopedName]:
        """Return the base classes: the latest declared first.

        This order, in which derived classes precede their bases, always gives a valid method
        resolution order.
        """
        return sorted(declaration.bases, key=self._places.__getitem__, reverse=True)

    def contested(self, declaration: Interface) -> dict[str, Declaration]:
        """Return attributes that bases define differently, with the definition that wins."""
        if len(declaration.bases) < 2:
            return {}
        by_name: dict[str, Declaration] = {}
        contested: dict[str, Declaration] = {}
        held = self._members_in(declaration.name)
        for base in self.bases(declaration):
            for attribute, inner in self._members_in(base).items():
                if by_name.setdefault(attribute, inner) is not inner:
                    contested[attribute] = held[attribute]
        return contested

    def hides(self, declaration: Interface) -> bool:
        """Return whether an attribute of the declaration differs from a base's."""
        held = self._members_in(declaration.name)
        return any(
            held[attribute] is not inner
            for base in declaration.bases
            for attribute, inner in self._members_in(base).items()
        )

    def _members_in(self, name: ScopedName) -> dict[str, Declaration]:
        """Return the declarations in an interface and its bases, by attribute."""
        if name not in self._holdings:
            declaration = self._model.find(name)
            assert isinstance(declaration, Interface)
            held: dict[str, Declaration] = {}
            for base in reversed(self.bases(declaration)):
                held |= self._members_in(base)
            for inner in self.inside(name):
                held[self._attribute(inner.name)] = inner
                if isinstance(inner, Enum):
                    for member in inner.members:
                        held[self._attribute((*name, member.name))] = inner
            self._holdings[name] = held
        return self._holdings[name]

    def _inherited_state(self, declaration: Valuetype) -> list[str]:
        """Return the Python names of the state of a valuetype's bases."""
        return [
            name
            for base in self._model.bases(declaration)
            if isinstance(base, Valuetype)
            for name in self.members(base).values()
        ]

    def attribute_names(self, module: str) -> frozenset[str]:
        """Return the attributes that classes of an implementation module have in class scope."""
        if module not in self._attributes:
            self._attributes[module] = frozenset(self._new_attribute_names(module))
        return self._attributes[module]

    def _new_attribute_names(self, module: str) -> set[str]:
        names: set[str] = set()
        for declaration in self.declarations(module):
            match declaration:
                case Struct() | ExceptionDecl() | Union() | Bitset():
                    names.update(self.members(declaration).values())
                    if isinstance(declaration, Union):
                        names.update(_UNION_FIELDS)
                case Valuetype():
                    names.update(self.members(declaration).values())
                    names.update(self.operations(declaration).values())
                case ValueBox():
                    names.add("value")
                case Interface():
                    names.update(self.operations(declaration).values())
                    names.update(self.contested(declaration))
            if self.is_nested(declaration.name):
                names.add(self._attribute(declaration.name))
                if isinstance(declaration, Enum):
                    scope = declaration.name[:-1]
                    names.update(
                        self._attribute((*scope, member.name))
                        for member in declaration.members
                    )
        return names

    def _depth(self, name: ScopedName) -> int:
        """Return how many leading parts are IDL modules."""
        scope = name[:-1]
        depth = self._depths.get(scope)
        if depth is not None:
            return depth
        known = len(scope)
        while scope[:known] not in self._depths:
            known -= 1
        for length in range(known + 1, len(scope) + 1):
            outer = self._depths[scope[: length - 1]]
            is_module = outer == length - 1 and scope[:length] not in self._names
            self._depths[scope[:length]] = length if is_module else outer
        return self._depths[scope]

    def _attribute(self, name: ScopedName) -> str:
        if self.is_nested(name):
            holder = self._model.find(name[:-1])
            return identifier(name[-1], OWN_NAMES.get(type(holder), ()))
        return identifier(name[-1], _PACKAGES if len(name) == 1 else ())

    @cached_property
    def _names(self) -> frozenset[ScopedName]:
        return frozenset(d.name for d in self._model.declarations)

    @cached_property
    def _places(self) -> dict[ScopedName, int]:
        return {d.name: place for place, d in enumerate(self._model.declarations)}

    @cached_property
    def _by_module(self) -> dict[str, list[Declaration]]:
        modules: dict[str, list[Declaration]] = {}
        for declaration in self._emitted:
            modules.setdefault(self._modules[declaration.file], []).append(declaration)
        return modules

    @cached_property
    def _by_scope(self) -> dict[ScopedName, list[Declaration]]:
        scopes: dict[ScopedName, list[Declaration]] = {}
        for declaration in self._emitted:
            scopes.setdefault(declaration.name[:-1], []).append(declaration)
        return scopes

    @cached_property
    def _emitted(self) -> list[Declaration]:
        """The declarations in order, nested ones before enclosing ones."""
        inside: dict[ScopedName, list[Declaration]] = {}
        outermost: list[Declaration] = []
        for declaration in self._model.declarations:
            if not self.is_nested(declaration.name):
                outermost.append(declaration)
            elif is_emitted(declaration):
                inside.setdefault(declaration.name[:-1], []).append(declaration)

        def with_inner(declaration: Declaration) -> Iterator[Declaration]:
            for inner in inside.get(declaration.name, ()):
                yield from with_inner(inner)
            if is_emitted(declaration):
                yield declaration

        if not inside:
            return [each for each in outermost if is_emitted(each)]
        return [each for outer in outermost for each in with_inner(outer)]

    @cached_property
    def _enumerators(self) -> dict[ScopedName, ScopedName]:
        return {
            (*d.name[:-1], e.name): d.name
            for d in self._model.declarations
            if isinstance(d, Enum | Bitmask)
            for e in d.members
        }

    def _name_classes(self, module: str) -> None:
        declarations = self.declarations(module)
        attributes = self.attribute_names(module)
        short = {d.name: "_".join(d.name[self._depth(d.name) :]) for d in declarations}
        count = Counter(short.values())
        identifiers = {
            name: text if count[text] == 1 else "_".join(name)
            for name, text in short.items()
        }
        reserved = attributes.union(HOMES, _ARGUMENTS, _FUTURE, self.taken_in(module))
        hidden = reserved.union(dir(builtins))
        ahead = _referred_ahead(declarations)
        plains = {text: identifier(text) for text in identifiers.values()}
        free = {_free(plain, reserved) for plain in plains.values()}
        taken: set[str] = set()
        for name, text in identifiers.items():
            plain = plains[text]
            chosen = _free(plain, hidden if name in ahead else reserved)
            while chosen in taken or (chosen not in (text, plain) and chosen in free):
                chosen += "_"
            taken.add(chosen)
            self._implementations[name] = self._homes[module], chosen


def _referred_ahead(declarations: Iterable[Declaration]) -> set[ScopedName]:
    """Return the declarations that a typedef before them refers to.

    mypy takes the name of a builtin in such a typedef for the builtin.
    """
    before: set[ScopedName] = set()
    names: set[ScopedName] = set()
    for declaration in declarations:
        if isinstance(declaration, Typedef):
            names.update(name for name in referred(declaration) if name not in before)
        before.add(declaration.name)
    return names


def distinct(names: Iterable[str], reserved: Collection[str]) -> dict[str, str]:
    """Return unique Python names for the members of one scope, none of them reserved."""
    preferred = list(names)
    identifiers = [identifier(name, reserved) for name in preferred]
    if identifiers == preferred:
        return dict(zip(preferred, identifiers, strict=True))
    unchanged = {
        n for n, chosen in zip(preferred, identifiers, strict=True) if n == chosen
    }
    taken = unchanged.union(reserved)
    result: dict[str, str] = {}
    for name, chosen in zip(preferred, identifiers, strict=True):
        if chosen != name:
            while chosen in taken:
                chosen += "_"
            taken.add(chosen)
        result[name] = chosen
    return result


def _free(name: str, taken: Collection[str]) -> str:
    while name in taken:
        name += "_"
    return name


def is_emitted(declaration: Declaration) -> bool:
    """Return whether the types back end generates code for the declaration."""
    return not isinstance(declaration, Component | Home | Native)


@lru_cache(maxsize=4096)
def package_path(scope: ScopedName) -> tuple[str, ...]:
    """Return the package path below the root of an IDL module: `("IIS",)` to `("iis",)`.

    It avoids rtgen's own packages.
    """
    if not scope:
        return ()
    *outer, name = scope
    package = identifier(name.lower(), () if outer else _PACKAGES)
    return (*package_path(tuple(outer)), package)


def is_package(module: str, name: ScopedName) -> bool:
    """Return whether a module below the root is the package of a declaration's scope."""
    return any(
        module == ".".join(package_path(name[:depth])) for depth in range(1, len(name))
    )
