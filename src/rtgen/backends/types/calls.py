"""The bodies of requests and replies: structs of the model that no definition file has.

A request is the `in` and `inout` parameters in order, a reply the return value and then the `inout`
and `out` parameters, a user exception its repository id and its members (CORBA 3.3 part 2, 9.4.2.2
and 9.4.3.2). As structs they have the codecs that every struct has. They stand in modules of their
own, `_idl.<file>_calls`, which only a transport that marshals imports.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from pathlib import PurePosixPath

from rtgen.backends.python_text import string_literal
from rtgen.backends.types.scope import Scope
from rtgen.layouts.cdr_types import CdrTypes, NotMarshalledError
from rtgen.layouts.representations import Representations
from rtgen.model import (
    VOID,
    Attribute,
    Declaration,
    Direction,
    ExceptionDecl,
    Interface,
    Member,
    Model,
    NamedType,
    Operation,
    Parameter,
    ScopedName,
    SequenceType,
    SourceFile,
    StringType,
    Struct,
    Type,
)
from rtgen.typemap.implementation_modules import implementation_modules

# Names that no definition can have: no identifier of IDL holds a space, or begins with `_`.
_RESULT = "_result"
_CONTEXT = "_context"
_ID = "_id"


@dataclass(frozen=True, slots=True)
class Call:
    """How one operation is marshalled, or why it is not (`refused`)."""

    operation: str
    request: Struct | None = None
    reply: Struct | None = None
    raises: tuple[ScopedName, ...] = ()
    oneway: bool = False
    refused: str = ""


class Calls:
    """What has to be added to a model so that the calls of its interfaces can be marshalled.

    `model` is the model with the bodies, `origins` the file that each file of bodies is for.
    """

    def __init__(self, model: Model, representations: Representations) -> None:
        self._types = CdrTypes(
            model, lambda d: {m.name: m.name for m in d.members}, representations
        )
        self._before = model
        self._modules = implementation_modules(model)
        self._files: dict[str, SourceFile] = {}
        self._bodies: list[Struct] = []
        self._raised: dict[ScopedName, Struct] = {}
        self.origins: dict[str, str] = {}
        self.of: dict[ScopedName, list[Call]] = {}
        for declaration in model.declarations:
            if isinstance(declaration, Interface) and not declaration.local:
                calls = list(self._calls(declaration))
                if calls:
                    self.of[declaration.name] = calls
        self.model = Model(
            (*model.files, *self._files.values()),
            (*model.declarations, *self._bodies),
            model.systems,
        )

    def file(self, interface: Interface) -> str | None:
        """The file of the bodies of an interface; None if nothing of it is marshalled."""
        return self._file(interface).name if interface.name in self.of else None

    def interfaces(self, file: str) -> list[Interface]:
        """The interfaces whose bodies stand in a file of bodies."""
        found = (self._before.find(name) for name in self.of)
        return [i for i in found if isinstance(i, Interface) and self.file(i) == file]

    def raised(self, exception: ScopedName) -> ScopedName:
        """The body of a reply that tells of an exception."""
        return self._raised[exception].name

    def _calls(self, interface: Interface) -> Iterator[Call]:
        for attribute in interface.attributes:
            for operation in _accessors(attribute):
                yield self._call(interface, operation)
        for operation in interface.operations:
            yield self._call(interface, operation)

    def _call(self, interface: Interface, operation: Operation) -> Call:
        self._file(interface)
        parameters = operation.parameters
        given = [_member(p) for p in parameters if p.direction is not Direction.OUT]
        if operation.context:
            given.append(_named(operation, _CONTEXT, SequenceType(StringType())))
        results = [_member(p) for p in parameters if p.direction is not Direction.IN]
        if operation.returns != VOID:
            results.insert(0, _named(operation, _RESULT, operation.returns))
        try:
            for member in (*given, *results):
                self._types.node(member.type)
        except NotMarshalledError as failure:
            return Call(operation.name, refused=str(failure))
        exceptions = tuple(dict.fromkeys(operation.raises))
        for exception in exceptions:
            self._add_raised(exception)
        return Call(
            operation.name,
            self._body(interface, operation, "request", "Arguments", given),
            self._body(interface, operation, "reply", "Results", results),
            exceptions,
            operation.oneway,
        )

    def _body(
        self,
        interface: Interface,
        operation: Operation,
        kind: str,
        what: str,
        members: list[Member],
    ) -> Struct | None:
        if not members:
            return None
        *scope, name = interface.name
        body = Struct(
            span=operation.span,
            doc=f"{what} of `{interface.scoped}::{operation.name}`.",
            name=(*scope, f"{name}.{operation.name} {kind}"),
            repository_id=operation.repository_id,
            file=self._file(interface).name,
            members=tuple(members),
        )
        self._bodies.append(body)
        return body

    def _add_raised(self, name: ScopedName) -> None:
        exception = self._before.find(name)
        if name in self._raised or not isinstance(exception, ExceptionDecl):
            return
        identity = Member(span=exception.span, name=_ID, type=StringType())
        body = Struct(
            span=exception.span,
            doc=f"The reply that tells of `{exception.scoped}`.",
            name=(f"{'.'.join(name)} raised",),
            repository_id=exception.repository_id,
            file=self._file(exception).name,
            members=(identity, *exception.members),
        )
        self._raised[name] = body
        self._bodies.append(body)

    def _file(self, declaration: Declaration) -> SourceFile:
        """The file of bodies for a declaration: one for each implementation module."""
        module = self._modules[declaration.file]
        if module not in self._files:
            owner = next(
                f for f in self._before.files if self._modules[f.name] == module
            )
            key = PurePosixPath(owner.key)
            calls = str(key.with_name(f"{key.stem}_calls{key.suffix}"))
            stem = PurePosixPath(owner.name).stem
            name = f"{owner.name} calls/{stem}_calls.idl"
            self._files[module] = replace(
                owner, name=name, key=calls, main=False, belongs_to=None
            )
            self.origins[name] = owner.name
        return self._files[module]


def _accessors(attribute: Attribute) -> Iterator[Operation]:
    """The operations that an attribute stands for (CORBA 3.3 part 2, 9.4.2.2)."""
    get = Operation(
        span=attribute.span,
        name=f"_get_{attribute.name}",
        returns=attribute.type,
        raises=attribute.get_raises,
        repository_id=attribute.repository_id,
    )
    yield get
    if not attribute.readonly:
        value = Parameter(
            span=attribute.span,
            direction=Direction.IN,
            name="value",
            type=attribute.type,
        )
        yield replace(
            get,
            name=f"_set_{attribute.name}",
            returns=VOID,
            parameters=(value,),
            raises=attribute.set_raises,
        )


def _named(operation: Operation, name: str, type_: Type) -> Member:
    return Member(span=operation.span, name=name, type=type_)


def _member(parameter: Parameter) -> Member:
    return Member(span=parameter.span, name=parameter.name, type=parameter.type)


class CallTable:
    """Writes the table of a module's calls, which the runtime looks operations up in."""

    def __init__(self, calls: Calls, scope: Scope) -> None:
        self._calls = calls
        self._py = scope

    def text(self, interfaces: Sequence[Interface]) -> str:
        """The table as one statement."""
        items = []
        for interface in interfaces:
            calls = ", ".join(
                f"{string_literal(call.operation)}: {self._call(call)}"
                for call in self._calls.of[interface.name]
            )
            items.append(f"{string_literal(interface.repository_id)}: {{{calls}}}")
        kind = f"{self._py.dict}[{self._py.str}, {self._py.dict}[{self._py.str}, {self._py.Call}]]"
        return f"_CALLS: {kind} = {{{', '.join(items)}}}"

    def _call(self, call: Call) -> str:
        py = self._py
        facts = []
        if call.refused:
            facts.append(f"refused={string_literal(call.refused)}")
        for key, body in (("request", call.request), ("reply", call.reply)):
            if body is not None:
                facts.append(f"{key}={py.reference(body.name)}")
                objects = [self._interface(member.type) for member in body.members]
                if any(name != "None" for name in objects):
                    facts.append(f"{key}_objects={_tuple(objects)}")
        if call.raises:
            pairs = [
                f"({py.reference(self._calls.raised(e))}, {py.reference(e)})"
                for e in call.raises
            ]
            facts.append(f"raises={_tuple(pairs)}")
        if call.oneway:
            facts.append("oneway=True")
        return f"{py.Call}({', '.join(facts)})"

    def _interface(self, type_: Type) -> str:
        """The class of an object that a member refers to, else `None`."""
        type_ = self._calls.model.unalias(type_)
        if isinstance(type_, NamedType):
            declaration = self._calls.model.find(type_.name)
            if isinstance(declaration, Interface):
                return self._py.reference(type_.name)
        return "None"


def _tuple(items: list[str]) -> str:
    return f"({items[0]},)" if len(items) == 1 else f"({', '.join(items)})"
