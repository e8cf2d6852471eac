"""The names of one implementation module: imports, and the spelling of each name."""

from __future__ import annotations

from collections.abc import Iterator

from rtgen.compiler.backends.kit.python_module import Import
from rtgen.compiler.model import Declaration, Interface, ScopedName, Typedef
from rtgen.compiler.typemap.python.idl_names import PythonNames
from rtgen.compiler.typemap.python.support import HOMES


class Scope:
    """Spells names and records the imports that they need.

    A name that is an attribute of some class of the module is imported as `_name`, so that it
    means the same in the body of every class.
    """

    def __init__(self, names: PythonNames, module: str) -> None:
        self._names = names
        self._home = names.home(module)
        self._attributes = names.attribute_names(module)
        self._taken = names.taken_in(module)
        self._imports: dict[tuple[str, str], str] = {}
        self.globals: set[str] = {*HOMES}
        """The names that function bodies must not use for variables."""
        self.defined = frozenset(
            name
            for declaration in names.declarations(module)
            for name in self._own_names(declaration)
        )
        """The names that the module defines for declarations."""
        self.globals.update(self.defined)

    def _own_names(self, declaration: Declaration) -> Iterator[str]:
        """The names that the module defines for a declaration."""
        name = declaration.name
        yield self.reference(name)
        match declaration:
            case Interface():
                yield self.companion(name, "Stub")
                yield self.companion(name, "Skeleton")
            case Typedef():
                yield self.companion(name, "Codec")
                yield self.alias(name)

    def __getattr__(self, name: str) -> str:
        """`py.dataclass` in a template: the name as spelled in the module, found once."""
        spelled = self.__dict__[name] = self.support(name)
        return spelled

    @property
    def class_variable(self) -> str:
        """The annotation of a class variable.

        msgspec recognizes it by name only, so a class with a member of that name omits it.
        """
        alone = not self._is_bound("ClassVar")
        return f": {self.ClassVar}" if alone else ""

    def support(self, name: str, module: str | None = None) -> str:
        """A name of the runtime, the standard library or the builtins."""
        home, _, original = (module or HOMES[name]).partition(":")
        local = f"_{name}" if self._is_bound(name) else name
        if home != "builtins" or local != name:
            self._imports[home, original or name] = local
            self.globals.add(local)
        return local

    def _is_bound(self, name: str) -> bool:
        """Return whether a name has another meaning in a class or in the module."""
        return name in self._attributes or name in self._taken

    def spell(self, module: str, name: str) -> str:
        """A support name in the form of the mapping table."""
        return self.support(name, module)

    def reference(self, name: ScopedName) -> str:
        """A declared type, constant or interface."""
        return self._declared(*self._names.implementation(name))

    def companion(self, name: ScopedName, suffix: str) -> str:
        """The companion of a declared type: its stub, skeleton or codec."""
        home, _ = self._names.implementation(name)
        return self._declared(home, self._names.companion(name, suffix))

    def alias(self, name: ScopedName) -> str:
        """The constant for the descriptor of a typedef."""
        home, class_name = self._names.implementation(name)
        return self._declared(home, f"_{class_name}_alias")

    def _declared(self, home: str, class_name: str) -> str:
        if home == self._home:
            return class_name
        key = home, class_name
        if key not in self._imports:
            local = class_name
            while local in self.globals or self._is_bound(local):
                local += "_"
            self._imports[key] = local
            self.globals.add(local)
        return self._imports[key]

    def imports(self) -> list[Import]:
        """Return the imports of the spelled names."""
        return [
            Import(module, "" if name == module else name, local)
            for (module, name), local in self._imports.items()
        ]
