"""Imports of a component's modules: types by their module, without clashes."""

from __future__ import annotations

from collections.abc import Collection, Iterable, Mapping

from rtgen.model import Model, ScopedName
from rtgen.typemap.idl_python import PythonMapping
from rtgen.typemap.idl_python_names import PythonNames
from rtgen.typemap.python_names import identifier


class Imports:
    """Allocates names and collects their imports.

    Types in IDL modules are named by their Python module (`iis.TimedPose2D`), those of the global
    scope directly. `root` is the root package as the module writes it: `...` or `refrobots`.
    `taken` are the names bound by the module itself. `external` gives the package of types
    outside the root package, by the displayed path of the declaring file.
    """

    def __init__(
        self,
        model: Model,
        names: PythonNames,
        root: str,
        taken: Collection[str],
        external: Mapping[str, str] | None = None,
    ) -> None:
        self.mapping = PythonMapping(model, self.type_name, self.spell, servants=True)
        self._model = model
        self._names = names
        self._root = root
        self._external = external or {}
        self._taken = set(taken)
        self._imported: dict[tuple[str, str], str] = {}

    def type_name(self, type_: ScopedName) -> str:
        """The expression for a declared type."""
        package, attribute = self._names.public(type_)
        root = self._external.get(self._model.find(type_).file, self._root)
        if package:
            inside = _module(root, package[:-1])
            return f"{self.spell(inside, package[-1])}.{attribute}"
        outer, dot, inner = attribute.partition(".")
        return self.spell(_module(root, ()), outer) + dot + inner

    def spell(self, module: str, name: str) -> str:
        """The name under which `name` of a module is imported; builtins have no module."""
        if not module:
            return name
        known = self._imported.get((module, name))
        if known is None:
            last = module.strip(".").rpartition(".")[2]
            clashes = name in self._taken
            known = identifier(
                f"{last}_{name}".strip("_") if clashes else name, self._taken
            )
            self._taken.add(known)
            self._imported[module, name] = known
        return known

    @property
    def locals(self) -> frozenset[str]:
        """The names bound by the imports."""
        return frozenset(self._imported.values())

    def lines(self, standard: bool = False) -> list[str]:
        """The import statements, sorted: those of the standard library, or all others."""
        modules: dict[str, list[str]] = {}
        for (module, name), local in sorted(self._imported.items()):
            if (module in _STANDARD) is standard:
                item = name if name == local else f"{name} as {local}"
                modules.setdefault(module, []).append(item)
        return [import_from(module, items) for module, items in modules.items()]


def _module(root: str, package: tuple[str, ...]) -> str:
    joint = "." if package and not root.endswith(".") else ""
    return root + joint + ".".join(package)


_STANDARD = ("decimal",)


def import_from(module: str, names: Iterable[str]) -> str:
    """`from module import names`, sorted."""
    return f"from {module} import {', '.join(sorted(names))}"
