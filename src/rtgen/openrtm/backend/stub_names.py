"""Names of types and interfaces in the Python packages that omniidl generates."""

from __future__ import annotations

from functools import cached_property

from rtgen.compiler.model import Interface, Model, ScopedName
from rtgen.facts.omniidl import mangled


class StubNames:
    """The names of a model's types."""

    def __init__(self, model: Model) -> None:
        self._model = model

    def stub_path(self, name: ScopedName) -> str:
        """Return a declared type: `IIS.TimedPose2D`, `_GlobalIDL.RefHard`."""
        scope = () if name[:1] in self._modules else ("_GlobalIDL",)
        return ".".join(map(mangled, (*scope, *name)))

    def skeleton_path(self, interface: Interface) -> str:
        """Return the base class of a servant: `_GlobalIDL__POA.RefHard`."""
        package, _, rest = self.stub_path(interface.name).partition(".")
        return f"{package}__POA.{rest}"

    @cached_property
    def _modules(self) -> frozenset[ScopedName]:
        declarations = self._model.declarations
        declared = {d.name for d in declarations}
        first = {d.name[:1] for d in declarations if len(d.name) > 1}
        return frozenset(first - declared)
