"""The `allocator` specifier: reads signatures, adds allocator ports to celltypes and composites."""

from __future__ import annotations

from dataclasses import dataclass

from rtgen.compiler.diagnostics import Related
from rtgen.compiler.frontends.cdl.names.entities import (
    Allocator,
    Celltype,
    Composite,
    Port,
    Report,
)
from rtgen.compiler.frontends.cdl.rules import celltypes as rules
from rtgen.compiler.frontends.cdl.syntax import tree
from rtgen.compiler.frontends.kit.suggestions import nearest
from rtgen.compiler.model.tecs import Signature, TecsDirection, TecsParameter

_ALLOCATOR = frozenset({"alloc", "dealloc"})
"""Functions of a signature that can be used as an allocator."""


def resolve(type_: Celltype, port: Port, report: Report) -> None:
    """Resolve the allocators of a port once all ports of the celltype are known."""
    for node in port.allocations:
        found = _Resolver(type_, port, node, report).result()
        if found is None:
            continue
        key = (node.path[0].text, node.path[1].text)
        if key in port.allocators:
            report(
                rules.ALLOCATOR_TWICE.at(
                    type_.place.span(node),
                    f"{'.'.join(key)} has two allocators",
                    related=[
                        Related(
                            type_.place.span(port.allocators[key].node), "the first"
                        )
                    ],
                    hint="remove one",
                )
            )
        else:
            port.allocators[key] = found


@dataclass(slots=True)
class _Resolver:
    type_: Celltype
    port: Port
    node: tree.Allocation
    report: Report

    def result(self) -> Allocator | None:
        node = self.node
        if len(node.path) != 2 or node.subscript is not None:
            form = "function.parameter"
            self._form(f"write {form} = ... or {form} <= ...")
            return None
        if node.operator == "=" and not isinstance(self.type_, Composite):
            self._form(
                "in a celltype write function.parameter <= cCall.function.parameter"
            )
            return None
        if self.port.signature is None:
            return None
        parameter = self._parameter(self.port.signature, *node.path)
        if parameter is None:
            return None
        return self._own() if node.operator == "=" else self._relay(parameter)

    def _form(self, hint: str) -> None:
        message = "this is not the form of an allocator here"
        span = self.type_.place.span(self.node)
        self.report(rules.ALLOCATOR_FORM.at(span, message, hint=hint))

    def _parameter(
        self, signature: Signature, function: tree.Name, parameter: tree.Name
    ) -> TecsParameter | None:
        """Return the send or receive parameter; None, after a diagnostic, if there is none."""
        place = self.type_.place
        owner = next((f for f in signature.functions if f.name == function.text), None)
        if owner is None:
            near = nearest(function.text, (f.name for f in signature.functions))
            self._unknown(function, f"{signature.scoped} has no function", near)
            return None
        found = next((p for p in owner.parameters if p.name == parameter.text), None)
        if found is None:
            near = nearest(parameter.text, (p.name for p in owner.parameters))
            self._unknown(parameter, f"{owner.name} has no parameter", near)
            return None
        if found.direction not in (TecsDirection.SEND, TecsDirection.RECEIVE):
            self.report(
                rules.ALLOCATOR_DIRECTION.at(
                    place.span(parameter),
                    f"{parameter.text} is {found.direction.value}, and needs no allocator",
                    related=[Related(found.span, "the parameter")],
                )
            )
            return None
        return found

    def _unknown(self, name: tree.Name, message: str, near: str | None) -> None:
        self.report(
            rules.ALLOCATOR_NAME.at(
                self.type_.place.span(name),
                f"{message} {name.text}",
                hint=f"did you mean {near}?" if near else None,
            )
        )

    def _own(self) -> Allocator | None:
        """Resolve `function.parameter = eAlloc`."""
        value = self.node.value
        if not isinstance(value, tree.ScopedName) or len(value.parts) != 1:
            self._form(
                "write function.parameter = eAlloc, an entry port of the composite"
            )
            return None
        name = value.parts[0]
        entry = self.type_.members.get(name.text)
        functions = (
            {f.name for f in entry.signature.functions}
            if isinstance(entry, Port) and entry.signature is not None
            else set()
        )
        if (
            not isinstance(entry, Port)
            or entry.kind != "entry"
            or not functions >= _ALLOCATOR
        ):
            entries = (p.name for p in self.type_.ports if p.kind == "entry")
            near = nearest(name.text, entries)
            self._unknown(name, "there is no entry port of an allocator", near)
            return None
        return Allocator(self.node, entry=name.text)

    def _relay(self, parameter: TecsParameter) -> Allocator | None:
        """Resolve `function.parameter <= cCall.function.parameter`."""
        value = self.node.value
        match value:
            case tree.Postfix(
                operand=tree.ScopedName(parts=(call,)),
                suffixes=(tree.Name() as function, tree.Name() as name),
            ):
                pass
            case _:
                self._form("write function.parameter <= cCall.function.parameter")
                return None
        port = self.type_.members.get(call.text)
        if not isinstance(port, Port):
            near = nearest(
                call.text, (p.name for p in self.type_.ports if p.kind == "call")
            )
            self._unknown(call, f"{self.type_.name} has no call port", near)
            return None
        if port.signature is None:
            return None
        found = self._parameter(port.signature, function, name)
        if found is None:
            return None
        if found.direction is not parameter.direction:
            self.report(
                rules.ALLOCATOR_DIRECTION.at(
                    self.type_.place.span(self.node),
                    f"{parameter.name} is {parameter.direction.value}, "
                    f"{found.name} is {found.direction.value}",
                    related=[
                        Related(parameter.span, "the one"),
                        Related(found.span, "the other"),
                    ],
                )
            )
            return None
        return Allocator(self.node, call.text, function.text, name.text)
