"""Scoped names in IDL text: declared names, and the form of a name in a scope."""

from __future__ import annotations

from collections.abc import Callable, Collection, Iterable, Iterator, Sequence

from rtgen.compiler.model import (
    Declaration,
    ExceptionDecl,
    Interface,
    Model,
    ScopedName,
    Struct,
    Union,
    Valuetype,
)


class ScopedNames:
    """The names of a model, of which some declarations are printed, in order."""

    def __init__(
        self,
        model: Model,
        printed: Iterable[Declaration],
        escape: Callable[[str], str],
    ) -> None:
        self.escape = escape
        self.done: set[ScopedName] = set()
        """The declarations printed so far."""
        self._model = model
        self._names = {declaration.name for declaration in model.declarations}
        self._own = {declaration.name for declaration in printed}
        self._bound_names: dict[ScopedName, frozenset[str]] = {}
        self._inside: dict[ScopedName, list[Declaration]] = {}
        for declaration in model.declarations:
            if self.is_inner(declaration):
                inner = self._inside.setdefault(declaration.name[:-1], [])
                inner.append(declaration)

    def __contains__(self, name: ScopedName) -> bool:
        return name in self._names

    def inside(self, scope: ScopedName) -> Sequence[Declaration]:
        """Return the declarations nested in a declaration."""
        return self._inside.get(scope, ())

    def is_written(self, name: ScopedName) -> bool:
        """Return whether a name is already declared: printed, or in an included file."""
        prefixes = (name[:depth] for depth in range(1, len(name) + 1))
        return name in self.done or (
            name in self._names and self._own.isdisjoint(prefixes)
        )

    def is_inner(self, declaration: Declaration) -> bool:
        """Return whether a declaration is nested in another one."""
        return declaration.name[:-1] in self._names

    def text(
        self, name: ScopedName, scope: ScopedName, beside: Collection[str] = ()
    ) -> str:
        """Return a scoped name, absolute if its first part is hidden here.

        A name that is used is also introduced into the scope (CORBA 2.6, 3.15.3).
        """
        text = "::".join(map(self.escape, name))
        first = name[0].lower()
        taken = first in {other.lower() for other in beside} or any(
            first in self._bound(scope[:depth]) for depth in range(1, len(scope) + 1)
        )
        return f"::{text}" if taken else text

    def _bound(self, scope: ScopedName) -> frozenset[str]:
        """Return the names bound in a scope, in lower case."""
        bound = self._bound_names.get(scope)
        if bound is None:
            depth = len(scope)
            names = {
                name[depth].lower()
                for name in self._names
                if len(name) > depth and name[:depth] == scope
            }
            if scope in self._names:
                names.update(map(str.lower, _parts(self._model.find(scope))))
            bound = self._bound_names[scope] = frozenset(names)
        return bound


def _parts(declaration: Declaration) -> Iterator[str]:
    """Yield the names of members, attributes, operations and factories of a declaration."""
    match declaration:
        case Struct(members=members) | ExceptionDecl(members=members):
            yield from (member.name for member in members)
        case Union(cases=cases):
            yield from (case.name for case in cases)
        case Interface() | Valuetype():
            yield from (attribute.name for attribute in declaration.attributes)
            yield from (operation.name for operation in declaration.operations)
            if isinstance(declaration, Valuetype):
                yield from (member.name for member in declaration.state)
                yield from (factory.name for factory in declaration.factories)
