"""The calls of interfaces: the members of requests and replies, and the table of a module.

A request is the `in` and `inout` parameters in order, a reply the return value and then the `inout`
and `out` parameters (CORBA 3.3 part 2, 9.4.2.2). The tables are in modules of their own, such as
`_idl.<file>_calls`, which only transports that marshal import; the runtime makes the bodies.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from pathlib import PurePosixPath

import msgspec
from msgspec.structs import replace

from rtgen.compiler.backends.kit.python_text import Bracketed, fit_bracketed, tuple_of
from rtgen.compiler.backends.kit.quoting.python import string_literal
from rtgen.compiler.backends.types.descriptions import Descriptions
from rtgen.compiler.backends.types.scope import Scope
from rtgen.compiler.layouts.cdr_types import CdrTypes, NotMarshalledError
from rtgen.compiler.layouts.representations import Representations
from rtgen.compiler.model import (
    VOID,
    Attribute,
    Direction,
    Interface,
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
from rtgen.compiler.typemap.python.idl_names import OWN_NAMES, distinct, is_package
from rtgen.compiler.typemap.python.implementation_modules import implementation_modules

# Names that no definition can have: no identifier of IDL starts with `_`.
_RESULT = "_result"
_CONTEXT = "_context"

Members = tuple[tuple[str, Type], ...]


class Call(msgspec.Struct, frozen=True):
    """The marshalling of an operation, or the reason why it has none (`refused`).

    `request` and `reply` are the names and types of the members of the bodies.
    """

    operation: str
    request: Members = ()
    reply: Members = ()
    raises: tuple[ScopedName, ...] = ()
    oneway: bool = False
    refused: str = ""


class Calls:
    """The calls of the interfaces of a model.

    `model` is the model with the files of the tables, `origins` the file that each of these is for.
    Without `marshalled` there are none.
    """

    def __init__(
        self, model: Model, representations: Representations, marshalled: bool = True
    ) -> None:
        self._types = CdrTypes(model, representations)
        self._before = model
        self._modules = implementation_modules(model)
        self._files: dict[str, SourceFile] = {}
        self._shapes: dict[object, tuple[Members, Members, str]] = {}
        """The bodies of operations with equal parameters and results."""
        self.origins: dict[str, str] = {}
        self.of: dict[ScopedName, list[Call]] = {}
        self.marshalled = marshalled
        for declaration in model.declarations if marshalled else ():
            if isinstance(declaration, Interface) and not declaration.local:
                calls = [*map(self._call, _operations(declaration))]
                if calls:
                    self.of[declaration.name] = calls
                    self._file(declaration)
        files = *model.files, *self._files.values()
        self.model = Model(files, model.declarations, model.systems)

    def file(self, interface: Interface) -> str | None:
        """The file of the table of an interface; None if it has no operations."""
        return self._file(interface).name if interface.name in self.of else None

    def interfaces(self, file: str) -> list[Interface]:
        """The interfaces whose calls a file contains."""
        declarations = (self._before.find(name) for name in self.of)
        return [
            i for i in declarations if isinstance(i, Interface) and self.file(i) == file
        ]

    def _call(self, operation: Operation) -> Call:
        shape = operation.shape
        if shape not in self._shapes:
            self._shapes[shape] = self._bodies(operation)
        request, reply, refused = self._shapes[shape]
        if refused:
            return Call(operation.name, refused=refused)
        raises = tuple(dict.fromkeys(operation.raises))
        return Call(operation.name, request, reply, raises, operation.oneway)

    def _bodies(self, operation: Operation) -> tuple[Members, Members, str]:
        """The members of the request and of the reply, and why they cannot be marshalled."""
        request, reply = _bodies(operation)
        try:
            for _, type_ in (*request, *reply):
                self._types.check(type_)
        except NotMarshalledError as failure:
            return (), (), str(failure)
        return request, reply, ""

    def _file(self, interface: Interface) -> SourceFile:
        """The file of the calls of an interface: one for each implementation module."""
        module = self._modules[interface.file]
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
                inner = is_package(home, interface.name)
                home = f"{home}._calls" if inner else f"{home}_calls"
            self._files[module] = replace(
                owner, name=name, key=calls, main=False, belongs_to=None, module=home
            )
            self.origins[name] = owner.name
        return self._files[module]


def _operations(interface: Interface) -> Iterator[Operation]:
    """The operations, those of the attributes first."""
    for attribute in interface.attributes:
        yield from _accessors(attribute)
    yield from interface.operations


def _bodies(operation: Operation) -> tuple[Members, Members]:
    """The members of the request, and those of the reply."""
    arguments = [(each.name, each.type) for each in operation.arguments]
    if operation.context:
        arguments.append((_CONTEXT, SequenceType(StringType())))
    results = [(each.name, each.type) for each in operation.results]
    if operation.returns != VOID:
        results.insert(0, (_RESULT, operation.returns))
    return tuple(arguments), tuple(results)


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


class CallTable:
    """Writes the table of a module's calls, in which the runtime looks up operations."""

    def __init__(
        self, calls: Calls, scope: Scope, describe: Descriptions, types: CdrTypes
    ) -> None:
        self._calls = calls
        self._py = scope
        self._describe = describe
        self._types = types
        self._bodies: dict[tuple[str, Members], list[str | Bracketed]] = {}
        """The facts of bodies, of which many operations have equal ones."""

    def text(self, interfaces: Sequence[Interface]) -> str:
        """The table."""
        items = [
            Bracketed(
                f"{string_literal(interface.repository_id)}: {{",
                [self._call(call) for call in self._calls.of[interface.name]],
                "}",
            )
            for interface in interfaces
        ]
        py = self._py
        kind = f"{py.dict}[{py.str}, {py.dict}[{py.str}, {py.CallTypes}]]"
        table = Bracketed(f"_CALLS: {kind} = {{", items, "}")
        return fit_bracketed(table, 0)

    def _call(self, call: Call) -> Bracketed:
        """The item of a call in the table."""
        py = self._py
        facts: list[str | Bracketed] = []
        if call.refused:
            facts.append(f"refused={string_literal(call.refused)}")
        for body in (("request", call.request), ("reply", call.reply)):
            if body not in self._bodies:
                self._bodies[body] = self._body(*body)
            facts += self._bodies[body]
        if call.raises:
            classes = [py.reference(name) for name in call.raises]
            facts.append(tuple_of(classes, "raises="))
        if call.oneway:
            facts.append("oneway=True")
        return Bracketed(f"{string_literal(call.operation)}: {py.CallTypes}(", facts)

    def _body(self, kind: str, members: Members) -> list[str | Bracketed]:
        """The facts of a body, which is a request or a reply."""
        if not members:
            return []
        names = distinct((name for name, _ in members), OWN_NAMES[Struct])
        described = [self._member(names[name], name, type_) for name, type_ in members]
        facts: list[str | Bracketed] = [Bracketed(f"{kind}={{", described, "}")]
        objects = [self._interface(type_) for _, type_ in members]
        if any(name != "None" for name in objects):
            facts.append(tuple_of(objects, f"{kind}_objects="))
        if any(self._types.has_headers(type_) for _, type_ in members):
            facts.append(f"{kind}_version=1")
        return facts

    def _member(self, attribute: str, name: str, type_: Type) -> str:
        described = self._describe.of(type_)
        if attribute != name:
            described = f'{self._py.idl}.member({described}, name="{name}")'
        return f'"{attribute}": {described}'

    def _interface(self, type_: Type) -> str:
        """The class of an object that a member refers to, else `None`."""
        declared = self._calls.model.declared(type_)
        if isinstance(declared, Interface):
            return self._py.reference(declared.name)
        return "None"
