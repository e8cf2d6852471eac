"""Names and imports of a module of conversions."""

from __future__ import annotations

import re
from collections.abc import Iterable

from rtgen.backends.kit.quoting.python import string_literal
from rtgen.backends.openrtm.plan import Unit
from rtgen.backends.openrtm.wire_names import CORBA_PACKAGE, WireNames, wire_id
from rtgen.model import Declaration, Enum, ExceptionDecl, Interface, ScopedName
from rtgen.typemap.python.names import identifier

WIRE = "rtgen.runtime.openrtm.wire"
"""The runtime module used by conversions."""

_VARIABLE = re.compile("(value|wire|item|part|state|made|error|result|context)(_.*)?")
"""Names of variables in the functions."""


class WireScope:
    """Allocates names, and collects imports and lookups at the top of the module.

    `defined` are the names defined by the module itself, `parameters` those of variables in its
    functions.
    """

    def __init__(
        self,
        unit: Unit,
        names: WireNames,
        module: str,
        defined: Iterable[str],
        parameters: Iterable[str],
    ) -> None:
        self.defined = frozenset(defined)
        self._unit = unit
        self._names = names
        self._module = module
        # Attributes of classes, which annotations there would refer to.
        self._hidden = {
            name
            for declaration in unit.model.declarations
            if isinstance(declaration, Interface)
            for name in names.python.operations(declaration).values()
        }
        self._taken = {*self.defined, *parameters, *self._hidden}
        self._imports: dict[tuple[str, str], str] = {}
        self._constants: dict[tuple[str, ScopedName], tuple[str, str]] = {}

    # Imports

    def helper(self, name: str, module: str = WIRE) -> str:
        """Return a name of the runtime or the standard library."""
        return self._imported(module, name)

    def spell(self, module: str, name: str) -> str:
        """Like `runtime`, for names of the mapping table; builtins have no module."""
        if not module and name not in self._hidden:
            return name
        return self._imported(module or "builtins", name)

    def type(self, name: ScopedName) -> str:
        """Return the generated class of a type or interface: `extended_data_types.Point2D`."""
        names = self._names.python
        if not names.is_own(name):
            path, attribute = names.public(name)
            package = names.public_package(name)
            outer, dot, inner = ".".join((*path, attribute)).partition(".")
            return self._imported(package, outer) + dot + inner
        home, local = names.implementation(name)
        package, _, module = home.rpartition(".")
        return f"{self._imported(self._home(package), module)}.{local}"

    def function(self, kind: str, name: ScopedName) -> str:
        """Return a conversion of a declared type: `kind` is an attribute of `Conversions`."""
        known = self._names.conversions(self._unit.model.find(name))
        function: str = getattr(known, kind)
        if known.package == self._unit.options.package and known.module == self._module:
            return function
        home = self._conversions(known.package)
        joint = "" if home.endswith(".") else "."
        return self._imported(f"{home}{joint}{known.module}", function)

    def _conversions(self, package: str) -> str:
        """Return a package of conversions in the form of this module's imports."""
        own = package == self._unit.options.package
        return "." if own else f"{package}.{CORBA_PACKAGE}"

    def _home(self, package: str) -> str:
        """Return a package of types in the form of this module's imports."""
        return f"..{package.removeprefix(self._unit.options.package).lstrip('.')}"

    def _imported(self, module: str, name: str) -> str:
        key = module, name
        if key not in self._imports:
            self._imports[key] = self._free(name)
        return self._imports[key]

    # Lookups at import

    def wire_class(self, declaration: Declaration) -> str:
        """Return omniORB's class of a struct, union or exception: `_Point2D`."""
        made = f"{self.helper('class_of')}({self._id(declaration)})"
        return self._constant(declaration, "", made)

    def items(self, enum: Enum) -> str:
        """Return omniORB's enumerators of an enum, by number."""
        made = f"{self.helper('items_of')}({self._id(enum)})"
        return self._constant(enum, "_items", made)

    def members(self, enum: Enum) -> str:
        """Return the generated enumerators of an enum, by number."""
        made = f"tuple({self.type(enum.name)})"
        return self._constant(enum, "_members", made)

    def octets(self, declaration: Declaration) -> str:
        """Return the conversion of a declared type via CDR."""
        ours = f"{self.type(declaration.name)}._descriptor_"
        is_raised = isinstance(declaration, ExceptionDecl)
        way = self.helper("ExceptionOctets" if is_raised else "Octets")
        made = f"{way}({ours}, {self._id(declaration)})"
        return self._constant(declaration, "_octets", made)

    def _id(self, declaration: Declaration) -> str:
        return string_literal(wire_id(declaration))

    def _constant(self, declaration: Declaration, suffix: str, made: str) -> str:
        key = suffix, declaration.name
        if key not in self._constants:
            known = self._names.conversions(declaration)
            self._constants[key] = self._free(f"_{known.name}{suffix}"), made
        return self._constants[key][0]

    def _free(self, name: str) -> str:
        name = identifier(name)
        if _VARIABLE.fullmatch(name):
            name = f"_{name}"
        while name in self._taken:
            name += "_"
        self._taken.add(name)
        return name

    def constant_lines(self) -> list[str]:
        """Return the statements that look up names."""
        return [f"{name} = {made}" for name, made in self._constants.values()]

    def import_lines(self) -> list[list[str]]:
        """Return the import statements: standard library, runtime, own packages."""
        modules: dict[str, list[str]] = {}
        for (module, name), local in sorted(self._imports.items()):
            text = name if name == local else f"{name} as {local}"
            modules.setdefault(module, []).append(text)
        blocks: list[list[str]] = [[], [], []]
        for module, names in modules.items():
            own = module.startswith(".") or f".{CORBA_PACKAGE}" in module
            rank = 2 if own else 1 if module.startswith("rtgen.") else 0
            names.sort(key=_order)
            blocks[rank].append(f"from {module} import {', '.join(names)}")
        return [block for block in blocks if block]


def _order(name: str) -> tuple[int, str]:
    """Return the sort key of isort: constants, classes, functions."""
    bare = name.partition(" ")[0]
    return (0 if bare.isupper() else 1 if bare[0].isupper() else 2, name)
