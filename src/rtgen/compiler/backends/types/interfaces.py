"""Data for the template of an interface: servant, stub and skeleton."""

from __future__ import annotations

from collections.abc import Sequence

import msgspec

from rtgen.compiler.backends.kit.member_texts import member_text, operation_text
from rtgen.compiler.backends.kit.python_text import tuple_of
from rtgen.compiler.backends.kit.quoting.python import docstring, string_literal
from rtgen.compiler.backends.kit.rendering import render
from rtgen.compiler.backends.types.calls import Calls
from rtgen.compiler.backends.types.descriptions import Descriptions, attribute_text
from rtgen.compiler.backends.types.scope import Scope
from rtgen.compiler.model import (
    Attribute,
    Interface,
    Operation,
    ScopedName,
)
from rtgen.compiler.typemap.python.idl import PythonMapping
from rtgen.compiler.typemap.python.idl_names import PythonNames


class _Attribute(msgspec.Struct, frozen=True):
    name: str
    type: str
    docstring: str
    readonly: bool
    get_operation: str
    set_operation: str


class Interfaces:
    """Writes interfaces into one module."""

    def __init__(
        self, calls: Calls, names: PythonNames, scope: Scope, describe: Descriptions
    ) -> None:
        self._calls = calls
        self._names = names
        self._py = scope
        self._describe = describe
        self._signatures: dict[object, str] = {}
        """The texts of signatures, of which many operations have equal ones."""
        self.mapping = PythonMapping(
            calls.model, scope.reference, scope.spell, servants=True
        )

    def text(
        self, declaration: Interface, nested: list[str], contested: dict[str, str]
    ) -> str:
        """The three classes; `contested`: statements for attributes that differ between bases."""
        py = self._py
        name = py.reference(declaration.name)
        stub, skeleton = py.Stub, py.Skeleton
        ordered = self._names.bases(declaration)
        called = self._names.operations(declaration)
        stub_bases = [py.companion(base, "Stub") for base in ordered]
        skeleton_bases = [py.companion(base, "Skeleton") for base in ordered]
        bases = [py.reference(base) for base in ordered]
        return render(
            "types/interface.py.j2",
            py=py,
            name=name,
            scoped=declaration.scoped,
            bases=", ".join(bases or [py.Servant]),
            docstring=docstring(declaration.doc, 4, f"`{declaration.scoped}`."),
            calls=self._calls_module(declaration),
            descriptor=self._describe.interface(declaration),
            nested=nested + [line for line in contested.values() if line not in nested],
            contested=list(contested.values()),
            attributes=[self._attribute(a, called) for a in declaration.attributes],
            operations=self._operations(declaration, called),
            stub=py.companion(declaration.name, "Stub"),
            stub_bases=", ".join([name, *(stub_bases or [stub])]),
            skeleton=py.companion(declaration.name, "Skeleton"),
            skeleton_bases=", ".join(skeleton_bases or [skeleton]),
        )

    def _calls_module(self, declaration: Interface) -> str:
        file = self._calls.file(declaration)
        if file is None:
            return ""
        home, _ = self._names.implementation(declaration.name)
        package = home.rpartition(".")[0]
        calls = self._names.home(self._names.module(file))
        return string_literal(calls.removeprefix(package))

    def _attribute(self, attribute: Attribute, called: dict[str, str]) -> _Attribute:
        name = called[attribute.name]
        otherwise = f"`{attribute_text(attribute)}`."
        return _Attribute(
            name=name,
            type=self.mapping.annotation(attribute.type),
            docstring=docstring(member_text(attribute, otherwise), 8, otherwise),
            readonly=attribute.readonly,
            get_operation=self._marks(attribute.name, name, attribute.get_raises),
            set_operation=self._marks(attribute.name, name, attribute.set_raises),
        )

    def _operations(self, declaration: Interface, called: dict[str, str]) -> str:
        """The methods; blank lines are only around those with docstrings."""
        # Not in the template: that takes as long as all else that is done for a method.
        py = self._py
        lines: list[str] = []
        spaced = True
        for operation in declaration.operations:
            name = called[operation.name]
            doc = docstring(operation_text(operation), 8).rstrip("\n")
            if spaced or doc:
                lines.append("")
            spaced = bool(doc)
            lines.append(f"    @{py.abstractmethod}")
            marks = self._marks(
                operation.name, name, operation.raises, operation.oneway
            )
            if marks:
                lines.append(f"    @{py.operation}({marks})")
            head = f"    def {name}{self._signature(operation)}"
            lines.append(f"{head}:{'' if doc else ' ...'}")
            if doc:
                lines.append(doc)
        return "\n".join(lines)

    def _signature(self, operation: Operation) -> str:
        """The parameters and the result of a method."""
        shape = operation.shape
        text = self._signatures.get(shape)
        if text is None:
            parameters = ", ".join(self.mapping.parameters(operation))
            text = f"({parameters}) -> {self.mapping.result(operation)}"
            self._signatures[shape] = text
        return text

    def _marks(
        self,
        name: str,
        python_name: str,
        raises: Sequence[ScopedName],
        oneway: bool = False,
    ) -> str:
        """The arguments of the decorator `operation`; empty if it is not needed."""
        marks: list[str] = [string_literal(name)] if name != python_name else []
        classes = [self._py.reference(r) for r in dict.fromkeys(raises)]
        if classes:
            marks.append(tuple_of(classes, "raises=").flat)
        if oneway:
            marks.append("oneway=True")
        return ", ".join(marks)
