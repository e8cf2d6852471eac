"""Names of the conversions between values and omniORB's objects."""

from __future__ import annotations

import keyword
from dataclasses import dataclass
from functools import cached_property

from rtgen.backends.openrtm.plan import Unit
from rtgen.model import Declaration, Interface, ScopedName, Struct
from rtgen.model.declarations import OPAQUE
from rtgen.typemap.python.idl import PythonMapping
from rtgen.typemap.python.idl_names import PythonNames

CORBA_PACKAGE = "_corba"
"""The package of the conversions, beside `_idl`."""


@dataclass(frozen=True, slots=True)
class Conversions:
    """Names of the conversions of a declared type or interface.

    `package` is the absolute name of its package, `module` the implementation module in it, `name`
    the class of the type in that.
    """

    package: str
    module: str
    name: str

    @property
    def path(self) -> str:
        """The absolute name of the module with the conversions."""
        return f"{self.package}.{CORBA_PACKAGE}.{self.module}"

    @property
    def new(self) -> str:
        """The function that makes a wire object with initial values."""
        return f"new_{self.name}"

    @property
    def fill(self) -> str:
        """The function that fills a wire object in place: `(wire, value)`."""
        return f"fill_{self.name}"

    @property
    def to(self) -> str:
        """The function that makes a new wire object from a value."""
        return f"to_{self.name}"

    @property
    def of(self) -> str:
        """The function that makes a value from a wire object."""
        return f"from_{self.name}"

    @property
    def objects(self) -> str:
        """The conversion of objects of an interface in arguments and results."""
        return f"{self.name}Objects"

    @property
    def servant(self) -> str:
        """The class that serves an interface to omniORB; constructed with a servant."""
        return f"{self.name}Servant"

    @property
    def stub(self) -> str:
        """The class that calls an omniORB object.

        Constructed with a function that returns it, or None.
        """
        return f"{self.name}Stub"


class WireNames:
    """Names of a package's types in generated code and in omniORB's stubs."""

    def __init__(self, unit: Unit) -> None:
        self._unit = unit
        self.python = PythonNames(unit.model, unit.options.package)
        self.mapping = PythonMapping(unit.model, ".".join)

    def conversions(self, declaration: Declaration) -> Conversions:
        """Return the names of the conversions of a struct, union, exception or interface."""
        _, name = self.python.implementation(declaration.name)
        module = self.python.module(declaration.file)
        return Conversions(self._unit.package_of(declaration.file), module, name)

    def stub_path(self, name: ScopedName) -> str:
        """Return a declared type in omniidl's packages: `IIS.TimedPose2D`, `_GlobalIDL.RefHard`."""
        scope = () if name[:1] in self._modules else ("_GlobalIDL",)
        return ".".join(map(mangled, (*scope, *name)))

    def skeleton_path(self, interface: Interface) -> str:
        """Return the base class of a servant: `_GlobalIDL__POA.RefHard`."""
        package, _, rest = self.stub_path(interface.name).partition(".")
        return f"{package}__POA.{rest}"

    @cached_property
    def _modules(self) -> frozenset[ScopedName]:
        declarations = self._unit.model.declarations
        declared = {d.name for d in declarations}
        first = {d.name[:1] for d in declarations if len(d.name) > 1}
        return frozenset(first - declared)


def wire_id(declaration: Declaration) -> str:
    """Return the repository id of a type in omniORB; a placeholder has its own."""
    if isinstance(declaration, Struct) and declaration.annotation(OPAQUE) is not None:
        return f"IDL:rtgen.opaque/{'/'.join(declaration.name)}:1.0"
    return declaration.repository_id


def mangled(name: str) -> str:
    """Return an identifier in omniidl's Python: keywords get a leading underscore."""
    return f"_{name}" if keyword.iskeyword(name) else name
