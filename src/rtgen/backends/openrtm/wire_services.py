"""Prints servants for omniORB that call rtgen's, and stubs that call omniORB's objects."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass

from rtgen.backends.kit.quoting.python import string_literal
from rtgen.backends.kit.rendering import render
from rtgen.backends.openrtm.conversion_code import ConversionCode
from rtgen.backends.openrtm.wire_names import WireNames, mangled
from rtgen.backends.openrtm.wire_scope import WireScope
from rtgen.model import (
    VOID,
    Attribute,
    Direction,
    Interface,
    Model,
    Operation,
    ScopedName,
    Type,
)
from rtgen.typemap.python.idl import PythonMapping
from rtgen.typemap.python.idl_names import distinct


@dataclass(frozen=True, slots=True)
class _Raise:
    type: str
    to: str


@dataclass(frozen=True, slots=True)
class _Operation:
    """An operation, or an accessor of an attribute, in both classes."""

    wire_name: str
    wire_parameters: str
    serve: str
    give: str
    raises: list[_Raise]
    decorators: list[str]
    name: str
    parameters: str
    result: str
    call: str
    take: list[str]
    declared: str
    key: str


class WireServices:
    """Generates the two classes of an interface."""

    def __init__(
        self, model: Model, names: WireNames, scope: WireScope, code: ConversionCode
    ) -> None:
        self._model = model
        self._names = names
        self._py = scope
        self._code = code
        self._mapping = PythonMapping(model, scope.type, scope.spell, servants=True)

    def text(self, interface: Interface) -> str:
        """Return the classes, and the conversion of the interface's objects."""
        scope = self._py
        ordered = self._names.python.bases(interface)
        servants = [scope.function("servant", base) for base in ordered]
        stubs = [scope.function("stub", base) for base in ordered]
        called = self._names.python.operations(interface)
        operations = [
            *(o for a in interface.attributes for o in self._accessors(a, called)),
            *(self._operation(o, called[o.name]) for o in interface.operations),
        ]
        return (
            render(
                "openrtm/service.py.j2",
                known=self._names.conversions(interface),
                scoped=interface.scoped,
                id=string_literal(interface.repository_id),
                type=scope.type(interface.name),
                any=scope.helper("Any", "typing"),
                reference=scope.helper("Reference"),
                raised=scope.helper("raised") if operations else "",
                objects=scope.helper("Objects"),
                servant_bases=f"({', '.join(servants)})" if servants else "",
                stub_bases=", ".join([*stubs, scope.type(interface.name)]),
                operations=operations,
            ).rstrip("\n")
            + "\n"
        )

    def _accessors(
        self, attribute: Attribute, called: dict[str, str]
    ) -> Iterator[_Operation]:
        name = called[attribute.name]
        yield self._made(
            wire_name=f"_get_{attribute.name}",
            method=f"self._servant.{name}",
            given=[],
            results=[attribute.type],
            raises=attribute.get_raises,
            name=name,
            decorators=[f"@{self._py.spell('', 'property')}"],
        )
        if not attribute.readonly:
            yield self._made(
                wire_name=f"_set_{attribute.name}",
                method=f"self._servant.{name} = ",
                given=[("value", attribute.type)],
                results=[],
                raises=attribute.set_raises,
                name=name,
                decorators=[f"@{name}.setter"],
            )

    def _operation(self, operation: Operation, name: str) -> _Operation:
        names = distinct(
            (p.name for p in operation.parameters), ("self", "error", *self._py.defined)
        )
        parameters = operation.parameters
        results: list[Type] = [operation.returns] if operation.returns != VOID else []
        results += [p.type for p in parameters if p.direction is not Direction.IN]
        return self._made(
            wire_name=mangled(operation.name),
            method=f"self._servant.{name}(",
            given=[
                (names[p.name], p.type)
                for p in parameters
                if p.direction is not Direction.OUT
            ],
            results=results,
            raises=operation.raises,
            name=name,
            decorators=[],
            context=bool(operation.context),
        )

    def _made(
        self,
        *,
        wire_name: str,
        method: str,
        given: Sequence[tuple[str, Type]],
        results: Sequence[Type],
        raises: Sequence[ScopedName],
        name: str,
        decorators: list[str],
        context: bool = False,
    ) -> _Operation:
        code = self._code
        any_type = self._py.helper("Any", "typing")
        inward = ", ".join(code.incoming(type_, n) for n, type_ in given)
        served = f"{method}{inward})" if method.endswith("(") else f"{method}{inward}"
        sent = [code.outgoing(type_, n) for n, type_ in given]
        taken = [n for n, _ in given]
        if context:
            sent.append(self._py.helper("NO_CONTEXT"))
            taken.append(_apart("context", taken))
        outward = ", ".join(sent)
        called = f"{self._py.helper('called')}(self._reference).{wire_name}({outward})"
        result, made = _apart("result", taken), _apart("made", taken)
        declared = ", ".join(
            f"{self._wire_class(e)}: {self._py.function('of', e)}"
            for e in dict.fromkeys(raises)
        )
        return _Operation(
            wire_name=wire_name,
            wire_parameters="".join(f", {n}: {any_type}" for n in taken),
            serve=f"{result} = {served}" if results else served,
            give=self._give(results, result),
            raises=[
                _Raise(self._py.type(e), self._py.function("to", e))
                for e in dict.fromkeys(raises)
            ],
            decorators=decorators,
            name=name,
            parameters=", ".join(
                ["self", *(f"{n}: {self._mapping.annotation(t)}" for n, t in given)]
            ),
            result=self._result(results),
            call=f"{result} = {called}" if results else called,
            take=list(self._take(results, result, made)),
            declared=f", {{{declared}}}" if declared else "",
            key=string_literal(wire_name),
        )

    def _wire_class(self, exception: ScopedName) -> str:
        return self._py.wire_class(self._model.find(exception))

    def _result(self, results: Sequence[Type]) -> str:
        annotations = [self._mapping.annotation(type_) for type_ in results]
        if len(annotations) > 1:
            return f"{self._py.spell('', 'tuple')}[{', '.join(annotations)}]"
        return annotations[0] if annotations else "None"

    def _give(self, results: Sequence[Type], result: str) -> str:
        """Return the return value of the servant: one value, or a tuple of several."""
        code = self._code
        if len(results) < 2:
            return "".join(code.outgoing(type_, result) for type_ in results)
        parts = [
            code.outgoing(type_, f"{result}[{place}]")
            for place, type_ in enumerate(results)
        ]
        return f"({', '.join(parts)})"

    def _take(self, results: Sequence[Type], result: str, made: str) -> Iterator[str]:
        """Yield the statements that return omniORB's result to the caller."""
        code = self._code
        if len(results) == 1:
            yield f"{made}: {self._result(results)} = {code.incoming(results[0], result)}"
            yield f"return {made}"
        elif results:
            parts = [
                code.incoming(type_, f"{result}[{place}]")
                for place, type_ in enumerate(results)
            ]
            yield f"return ({', '.join(parts)})"


def _apart(name: str, given: Sequence[str]) -> str:
    """Return a variable name distinct from all parameters."""
    while name in given:
        name += "_"
    return name
