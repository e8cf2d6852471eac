"""The bodies of requests and replies, as synthetic structs of the model.

A request is the `in` and `inout` parameters in order, a reply the return value and then the `inout`
and `out` parameters, a user exception its repository id and its members (CORBA 3.3 part 2, 9.4.2.2
and 9.4.3.2). They are marshalled by the codecs of structs, and defined in modules of their
own, such as `_idl.<file>_calls`, which only transports that marshal import.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterator, Sequence
from pathlib import PurePosixPath

import msgspec
from msgspec.structs import replace

from rtgen.compiler.backends.kit.python_text import Bracketed, fit_bracketed, tuple_of
from rtgen.compiler.backends.kit.quoting.python import string_literal
from rtgen.compiler.backends.types.scope import Scope
from rtgen.compiler.layouts.cdr_types import CdrTypes, NotMarshalledError
from rtgen.compiler.layouts.representations import Representations
from rtgen.compiler.model import (
    VOID,
    Attribute,
    Declaration,
    Direction,
    ExceptionDecl,
    Interface,
    Member,
    Model,
    Operation,
    Parameter,
    ScopedName,
    SequenceType,
    SourceFile,
    StringType,
    Struct,
    Type,
)
from rtgen.compiler.typemap.python.idl_names import is_package
from rtgen.compiler.typemap.python.implementation_modules import implementation_modules

_MANY = 8
"""From this number of operations in an interface on, operations of equal shape share bodies."""

# Names that no definition can have: no identifier of IDL contains a space, or starts with `_`.
_RESULT = "_result"
_CONTEXT = "_context"
_ID = "_id"


class Call(msgspec.Struct, frozen=True):
    """The marshalling of an operation, or the reason why it has none (`refused`)."""

    operation: str
    request: Struct | None = None
    reply: Struct | None = None
    raises: tuple[ScopedName, ...] = ()
    oneway: bool = False
    refused: str = ""


class Calls:
    """The additions to a model by which the calls of its interfaces can be marshalled.

    `model` is the model with the bodies, `origins` the file that each file of bodies is for.
    Without `marshalled` nothing is added.
    """

    def __init__(
        self, model: Model, representations: Representations, marshalled: bool = True
    ) -> None:
        self._types = CdrTypes(model, representations)
        self._before = model
        self._modules = implementation_modules(model)
        self._files: dict[str, SourceFile] = {}
        self._bodies: list[Struct] = []
        self._raised: dict[ScopedName, Struct] = {}
        self._shapes: dict[tuple[tuple[str, Type], ...], int] = {}
        self._shape_of: dict[ScopedName, int] = {}
        self.origins: dict[str, str] = {}
        self.of: dict[ScopedName, list[Call]] = {}
        self.marshalled = marshalled
        for declaration in model.declarations if marshalled else ():
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
        """The file of the bodies of an interface; None if no operation is marshalled."""
        return self._file(interface).name if interface.name in self.of else None

    def interfaces(self, file: str) -> list[Interface]:
        """The interfaces whose bodies a file contains."""
        declarations = (self._before.find(name) for name in self.of)
        return [
            i for i in declarations if isinstance(i, Interface) and self.file(i) == file
        ]

    def raised(self, exception: ScopedName) -> ScopedName:
        """The body of a reply that carries a user exception."""
        return self._raised[exception].name

    def shape_of(self, body: ScopedName) -> int | None:
        """Return the number of the shape of a request or a reply with results.

        Bodies with equal members have the same. None for other declarations.
        """
        return self._shape_of.get(body)

    def _calls(self, interface: Interface) -> Iterator[Call]:
        operations = [o for a in interface.attributes for o in _accessors(a)]
        parts = [
            (operation, *bodies, self._shape(bodies[0]), self._shape(bodies[1]))
            for operation in (*operations, *interface.operations)
            for bodies in [_bodies(operation)]
        ]
        numbers = Counter(
            shape
            for _, _, _, request, reply in parts
            for shape in (("request", request), ("reply", reply))
        )
        shared: dict[object, Struct] = {}
        for operation, arguments, results, of_request, of_reply in parts:
            self._file(interface)
            try:
                for member in (*arguments, *results):
                    self._types.check(member.type)
            except NotMarshalledError as failure:
                yield Call(operation.name, refused=str(failure))
                continue
            exceptions = tuple(dict.fromkeys(operation.raises))
            for exception in exceptions:
                self._add_raised(exception)
            bodies: list[Struct | None] = []
            for kind, what, members, number_of_shape in (
                ("request", "Arguments", arguments, of_request),
                ("reply", "Results", results, of_reply),
            ):
                shape = kind, number_of_shape
                body = shared.get(shape) if members else None
                if members and body is None:
                    number = len(shared) + 1 if numbers[shape] > _MANY else 0
                    body = self._body(interface, operation, kind, what, members, number)
                    if number:
                        shared[shape] = body
                bodies.append(body)
            request, reply = bodies
            yield Call(operation.name, request, reply, exceptions, operation.oneway)

    def _shape(self, members: Sequence[Member]) -> int:
        """The number of the shape of a body; operations of equal shape can share bodies."""
        shape = tuple([(member.name, member.type) for member in members])
        return self._shapes.setdefault(shape, len(self._shapes))

    def _body(
        self,
        interface: Interface,
        operation: Operation,
        kind: str,
        what: str,
        members: list[Member],
        shared: int,
    ) -> Struct:
        """A body of one operation, or of several (`shared` is a number for it)."""
        *scope, name = interface.name
        of, id_ = operation.name, operation.repository_id
        doc = f"{what} of `{interface.scoped}::{of}`."
        if shared:
            types = ", ".join(str(member.type) for member in members)
            of, id_ = f"{shared} {types}", interface.repository_id
            doc = f"{what} of several operations of `{interface.scoped}`: {types}."
        body = Struct(
            span=operation.span,
            doc=doc,
            name=(*scope, f"{name}.{of} {kind}"),
            repository_id=id_,
            file=self._file(interface).name,
            members=tuple(members),
        )
        self._bodies.append(body)
        self._shape_of[body.name] = self._shape(members)
        return body

    def _add_raised(self, name: ScopedName) -> None:
        exception = self._before.find(name)
        if name in self._raised or not isinstance(exception, ExceptionDecl):
            return
        identity = Member(span=exception.span, name=_ID, type=StringType())
        body = Struct(
            span=exception.span,
            doc=f"The reply with the exception `{exception.scoped}`.",
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
            home = owner.module
            if home:
                inner = is_package(home, declaration.name)
                home = f"{home}._calls" if inner else f"{home}_calls"
            self._files[module] = replace(
                owner, name=name, key=calls, main=False, belongs_to=None, module=home
            )
            self.origins[name] = owner.name
        return self._files[module]


def _bodies(operation: Operation) -> tuple[list[Member], list[Member]]:
    """The members of the request body, and those of the reply body."""
    arguments = [*map(_member, operation.arguments)]
    if operation.context:
        arguments.append(_named(operation, _CONTEXT, SequenceType(StringType())))
    results = [*map(_member, operation.results)]
    if operation.returns != VOID:
        results.insert(0, _named(operation, _RESULT, operation.returns))
    return arguments, results


def _accessors(attribute: Attribute) -> Iterator[Operation]:
    """The operations of an attribute (CORBA 3.3 part 2, 9.4.2.2)."""
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
    """Writes the table of a module's calls, in which the runtime looks up operations."""

    def __init__(self, calls: Calls, scope: Scope) -> None:
        self._calls = calls
        self._py = scope
        self._common: dict[tuple[ScopedName, ...], str] = {}

    def text(self, interfaces: Sequence[Interface]) -> str:
        """The table, after the exceptions shared by several calls."""
        raised = Counter(
            call.raises for i in interfaces for call in self._calls.of[i.name]
        )
        common = [
            raises for raises, count in raised.items() if raises and count > _MANY
        ]
        self._common = {r: f"_RAISES_{n}" for n, r in enumerate(common, 1)}
        before = [
            f"{name} = {self._raised(r).flat}\n" for r, name in self._common.items()
        ]
        items = [
            Bracketed(
                f"{string_literal(interface.repository_id)}: {{",
                [self._call(call) for call in self._calls.of[interface.name]],
                "}",
            )
            for interface in interfaces
        ]
        kind = f"{self._py.dict}[{self._py.str}, {self._py.dict}[{self._py.str}, {self._py.Call}]]"
        table = Bracketed(f"_CALLS: {kind} = {{", items, "}")
        return "".join(before) + fit_bracketed(table, 0)

    def _raised(self, raises: tuple[ScopedName, ...], head: str = "") -> Bracketed:
        py = self._py
        pairs = [
            Bracketed("(", [py.reference(self._calls.raised(e)), py.reference(e)])
            for e in raises
        ]
        return tuple_of(pairs, head)

    def _call(self, call: Call) -> Bracketed:
        """The item of a call in the table."""
        py = self._py
        facts: list[str | Bracketed] = []
        if call.refused:
            facts.append(f"refused={string_literal(call.refused)}")
        for key, body in (("request", call.request), ("reply", call.reply)):
            if body is not None:
                facts.append(f"{key}={py.reference(body.name)}")
                objects = [self._interface(member.type) for member in body.members]
                if any(name != "None" for name in objects):
                    facts.append(tuple_of(objects, f"{key}_objects="))
        if call.raises:
            common = self._common.get(call.raises)
            facts.append(
                f"raises={common}" if common else self._raised(call.raises, "raises=")
            )
        if call.oneway:
            facts.append("oneway=True")
        return Bracketed(f"{string_literal(call.operation)}: {py.Call}(", facts)

    def _interface(self, type_: Type) -> str:
        """The class of an object that a member refers to, else `None`."""
        declared = self._calls.model.declared(type_)
        if isinstance(declared, Interface):
            return self._py.reference(declared.name)
        return "None"
