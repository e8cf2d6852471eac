"""Imports of a component's modules: types by their module, without clashes."""

from __future__ import annotations

from collections.abc import Collection

from rtgen.compiler.backends.kit.python_module import Import, imports_of
from rtgen.compiler.model import Model, ScopedName
from rtgen.compiler.typemap.python.idl import PythonMapping
from rtgen.compiler.typemap.python.idl_names import PythonNames
from rtgen.compiler.typemap.python.names import identifier


class Imports:
    """Allocates names and collects their imports.

    Types in IDL modules are named by their Python module (`iis.TimedPose2D`), those of the global
    scope directly, and those of the module itself (`own`, by its absolute name) as it has them.
    `taken` are the names bound by the module itself, `hidden` those of attributes of its classes,
    which annotations there would refer to.
    """

    def __init__(
        self,
        model: Model,
        names: PythonNames,
        taken: Collection[str],
        own: str = "",
        hidden: Collection[str] = (),
    ) -> None:
        self.mapping = PythonMapping(model, self.type_name, self.spell, servants=True)
        self._names = names
        self._own = own
        self._hidden = hidden
        self._taken = {*taken, *hidden}
        self._imported: dict[tuple[str, str], str] = {}

    def type_name(self, type_: ScopedName) -> str:
        """The expression for a declared type."""
        home, name = self._names.implementation(type_)
        if home == self._own:
            return name
        path, attribute = self._names.public(type_)
        root = self._names.public_package(type_)
        if path:
            *outer, last = path
            return f"{self.spell('.'.join((root, *outer)), last)}.{attribute}"
        first, dot, inner = attribute.partition(".")
        return self.spell(root, first) + dot + inner

    def spell(self, module: str, name: str) -> str:
        """The name under which `name` of a module is imported; builtins have no module."""
        if not module:
            if name not in self._hidden:
                return name
            module = "builtins"
        spelling = self._imported.get((module, name))
        if spelling is None:
            last = module.rpartition(".")[2]
            clashes = name in self._taken
            spelling = identifier(f"{last}_{name}" if clashes else name, self._taken)
            self._taken.add(spelling)
            self._imported[module, name] = spelling
        return spelling

    @property
    def locals(self) -> frozenset[str]:
        """The names bound by the imports."""
        return frozenset(self._imported.values())

    def imports(self) -> list[Import]:
        """Return the imports of the allocated names."""
        return imports_of(self._imported)
