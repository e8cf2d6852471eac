"""`require`: reads singletons, adds call ports that are joined automatically."""

from __future__ import annotations

from collections.abc import Callable

import msgspec

from rtgen.compiler.diagnostics import Related
from rtgen.compiler.frontends.cdl.names.entities import (
    DECLARE,
    Cell,
    Celltype,
    Member,
    Place,
    Port,
    Report,
)
from rtgen.compiler.frontends.cdl.names.scopes import Entity, Kind
from rtgen.compiler.frontends.cdl.rules import celltypes as rules
from rtgen.compiler.frontends.cdl.syntax import statements, tree
from rtgen.compiler.frontends.kit.suggestions import nearest

_REQUIRABLE = (Kind.CELLTYPE, Kind.CELL)
_NAME = "_require_call_port_{}_{}"
"""Format of tecsgen's name for a `require` without one."""


class Requirements(msgspec.Struct, eq=False):
    """Analyses the `require` statements of celltypes.

    `add` adds a member to a celltype; `unseen`: whether a plug-in or a missing import may
    declare an unknown name.
    """

    _add: Callable[[Celltype, Member], bool]
    _unseen: Callable[[tree.ScopedName, Place], bool]
    _report: Report

    def take(self, type_: Celltype, node: statements.Require) -> None:
        """Add the port of a `require`."""
        place = type_.place
        target = self._required_type(node, place)
        if target is None:
            return
        entity, required = target
        port = required.members.get(node.target.port.text)
        if not isinstance(port, Port) or port.kind != "entry" or port.array:
            entries = [p.name for p in required.ports if p.kind == "entry"]
            near = nearest(node.target.port.text, entries)
            what = (
                "is an array"
                if isinstance(port, Port) and port.array
                else "is not an entry port"
            )
            self._report(
                rules.REQUIRED_NOT_ENTRY.at(
                    place.span(node.target.port),
                    f"{node.target.port.text} {what} of {required.name}",
                    related=[Related(required.entity.place, "declared here")],
                    hint=f"did you mean {near}?" if near else None,
                )
            )
            return
        if port.signature is None:
            return
        if node.name is not None:
            name = node.name.text
        elif self._clash(type_, node, port, place):
            return
        else:
            name = _NAME.format(required.name, port.name)
        self._add(
            type_,
            Port(
                name=name,
                kind="call",
                signature=port.signature,
                signature_name=port.signature_name,
                span=place.span(node.name or node.target),
                required=entity,
                required_port=port.name,
            ),
        )

    def _required_type(
        self, node: statements.Require, place: Place
    ) -> tuple[Entity, Celltype] | None:
        owner = node.target.owner
        entity = place.lookup(owner)
        if entity is None and self._unseen(owner, place):
            return None
        if not isinstance(entity, Entity) or entity.kind not in _REQUIRABLE:
            what = "is not known" if entity is None else f"is a {entity.kind}"
            self._report(
                rules.UNKNOWN_REQUIRED.at(
                    place.span(owner),
                    f"{owner} {what}: a requirement names a celltype or a cell",
                    hint=place.near(owner.parts[-1], *_REQUIRABLE) or DECLARE,
                )
            )
            return None
        type_ = entity.component
        if isinstance(type_, Cell):
            type_ = type_.celltype
        if not isinstance(type_, Celltype):
            return None
        if not type_.singleton:
            self._report(
                rules.REQUIRED_NOT_SINGLETON.at(
                    place.span(owner),
                    f"{type_.name} is not a singleton",
                    related=[Related(type_.entity.place, "declared here")],
                    hint="put [singleton] before it, or use a call port",
                )
            )
        return entity, type_

    def _clash(
        self, type_: Celltype, node: statements.Require, port: Port, place: Place
    ) -> bool:
        """Return whether a function of the port has a name that is already used; reports it."""
        assert port.signature is not None
        names = {f.name for f in port.signature.functions}
        for other in type_.ports:
            if not other.name.startswith(_NAME.partition("{")[0]):
                continue
            assert other.signature is not None
            shared = names & {f.name for f in other.signature.functions}
            if shared or other.signature.name == port.signature.name:
                what = ", ".join(sorted(shared)) or "none at all"
                self._report(
                    rules.REQUIRE_CLASH.at(
                        place.span(node.target),
                        f"two required ports have functions of one name: {what}",
                        related=[Related(other.span, "the other port")],
                        hint="give one a name: require cName = ...",
                    )
                )
                return True
        return False
