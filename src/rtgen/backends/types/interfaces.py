"""What the template of an interface needs: servant, stub and skeleton."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

from rtgen.backends.python_text import docstring, string_literal
from rtgen.backends.rendering import render
from rtgen.backends.types.calls import Calls
from rtgen.backends.types.descriptions import Descriptions, attribute_text, signature
from rtgen.backends.types.scope import Scope
from rtgen.model import (
    VOID,
    Attribute,
    Direction,
    Interface,
    Operation,
    ScopedName,
    Type,
)
from rtgen.typemap.idl_python import PythonMapping, PythonNames, distinct


@dataclass(frozen=True, slots=True)
class _Attribute:
    name: str
    type: str
    docstring: str
    readonly: bool
    key: str
    get: str
    set: str
    get_raises: str
    set_raises: str


@dataclass(frozen=True, slots=True)
class _Operation:
    name: str
    parameters: str
    result: str
    docstring: str
    key: str
    call: str
    count: int
    raises: str
    dispatcher: str


class Interfaces:
    """Writes interfaces into one module."""

    def __init__(
        self, calls: Calls, names: PythonNames, scope: Scope, describe: Descriptions
    ) -> None:
        self._calls = calls
        self._names = names
        self._py = scope
        self._describe = describe
        self._mapping = PythonMapping(
            calls.model, scope.reference, scope.spell, servants=True
        )

    def text(
        self, declaration: Interface, nested: list[str], contested: dict[str, str]
    ) -> str:
        """The three classes; `contested` are statements for what bases have differently."""
        py = self._py
        name = py.reference(declaration.name)
        stub, skeleton = py.Stub, py.Skeleton
        ordered = self._names.bases(declaration)
        called = self._names.operations(declaration)
        stub_bases = [py.companion(base, "Stub") for base in ordered]
        skeleton_bases = [py.companion(base, "Skeleton") for base in ordered]
        bases = [py.reference(base) for base in ordered]
        doc = declaration.doc or f"`{declaration.scoped}`."
        return render(
            "types/interface.py.j2",
            py=py,
            name=name,
            scoped=declaration.scoped,
            bases=", ".join(bases or [py.Servant]),
            docstring=docstring(doc, 4),
            calls=self._calls_module(declaration),
            descriptor=self._describe.interface(declaration),
            nested=nested + [line for line in contested.values() if line not in nested],
            contested=list(contested.values()),
            attributes=[self._attribute(a, called) for a in declaration.attributes],
            operations=[self._operation(o, called) for o in declaration.operations],
            stub=py.companion(declaration.name, "Stub"),
            stub_bases=", ".join([name, *(stub_bases or [stub])]),
            skeleton=py.companion(declaration.name, "Skeleton"),
            skeleton_bases=", ".join(skeleton_bases or [skeleton]),
        )

    def _calls_module(self, declaration: Interface) -> str:
        file = self._calls.file(declaration)
        return "" if file is None else string_literal(f".{self._names.module(file)}")

    def _attribute(self, attribute: Attribute, called: dict[str, str]) -> _Attribute:
        name = called[attribute.name]
        return _Attribute(
            name=name,
            type=self._mapping.annotation(attribute.type),
            docstring=docstring(attribute.doc or f"`{attribute_text(attribute)}`.", 8),
            readonly=attribute.readonly,
            key=string_literal(name),
            get=string_literal(f"_get_{attribute.name}"),
            set=string_literal(f"_set_{attribute.name}"),
            get_raises=self._raises(attribute.get_raises),
            set_raises=self._raises(attribute.set_raises),
        )

    def _operation(self, operation: Operation, called: dict[str, str]) -> _Operation:
        names = _parameter_names(operation)
        given = [p for p in operation.parameters if p.direction is not Direction.OUT]
        key = string_literal(operation.name)
        return _Operation(
            name=called[operation.name],
            parameters=self.parameters(operation),
            result=self.result(operation),
            docstring=docstring(operation.doc or f"`{signature(operation)}`.", 8),
            key=key,
            call=", ".join([key, *(names[p.name] for p in given)]),
            count=len(given),
            raises=self._raises(operation.raises),
            dispatcher="_send_" if operation.oneway else "_call_",
        )

    def annotation(self, type_: Type) -> str:
        """The annotation of a parameter or attribute."""
        return self._mapping.annotation(type_)

    def parameters(self, operation: Operation) -> str:
        """What a method takes: `self`, then what is not only out."""
        names = _parameter_names(operation)
        given = [p for p in operation.parameters if p.direction is not Direction.OUT]
        annotated = [f"{names[p.name]}: {self.annotation(p.type)}" for p in given]
        return ", ".join(["self", *annotated])

    def result(self, operation: Operation) -> str:
        """As omniORBpy: nothing, one result, or a tuple with the return value first."""
        types: list[Type] = [] if operation.returns == VOID else [operation.returns]
        types += [
            p.type for p in operation.parameters if p.direction is not Direction.IN
        ]
        annotations = [self._mapping.annotation(type_) for type_ in types]
        if len(annotations) > 1:
            return f"{self._py.tuple}[{', '.join(annotations)}]"
        return annotations[0] if annotations else "None"

    def _raises(self, names: Sequence[ScopedName]) -> str:
        classes = [self._py.reference(name) for name in dict.fromkeys(names)]
        if not classes:
            return ""
        return (
            f", ({classes[0]},)" if len(classes) == 1 else f", ({', '.join(classes)})"
        )


def _parameter_names(operation: Operation) -> dict[str, str]:
    return distinct((p.name for p in operation.parameters), ("self",))
