"""The IDL of a CDL file: its signatures as interfaces, with their components."""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable, Collection, Iterator, Mapping, Sequence
from typing import TypeVar

import msgspec
from msgspec.structs import replace

from rtgen.compiler.diagnostics import Diagnostic, Span
from rtgen.compiler.lowering.tecs.idl_names import (
    AnonymousTypes,
    IdlNames,
    common_fields,
)
from rtgen.compiler.lowering.tecs.plan import Service, TecsPackage
from rtgen.compiler.lowering.tecs.rtc_components import (
    COMMUNICATION,
    RTCS,
    components_of,
    marshaller_module,
)
from rtgen.compiler.lowering.tecs.rules import NOT_IN_IDL
from rtgen.compiler.model import (
    VOID,
    Component,
    Const,
    ConstantValue,
    Declaration,
    Direction,
    Interface,
    Member,
    Model,
    NamedType,
    Operation,
    Parameter,
    Primitive,
    PrimitiveType,
    ScopedName,
    StringType,
    Struct,
    Type,
    Typedef,
)
from rtgen.compiler.model.c_types import CPointerType, CScalarType, CStructType, resolve
from rtgen.compiler.model.graphs import reached
from rtgen.compiler.model.tecs import (
    TecsConst,
    TecsDeclaration,
    TecsDirection,
    TecsFunction,
    TecsParameter,
    TecsStruct,
    TecsTypedef,
)
from rtgen.compiler.typemap.python.implementation_modules import referred
from rtgen.compiler.typemap.python.names import identifier
from rtgen.compiler.typemap.python.support import BASE_NAMES, HOMES
from rtgen.compiler.typemap.tecs.idl import IdlTypes, NotInIdlError
from rtgen.compiler.typemap.tecs.python import (
    MARSHALLER_NAMES,
    codec_class,
    struct_class,
)
from rtgen.facts.tdr import Scalar

_DIRECTIONS = {
    TecsDirection.IN: Direction.IN,
    TecsDirection.SEND: Direction.IN,
    TecsDirection.OUT: Direction.OUT,
    TecsDirection.RECEIVE: Direction.OUT,
    TecsDirection.INOUT: Direction.INOUT,
}
_D = TypeVar("_D", bound=TecsDeclaration)
_ANY = PrimitiveType(Primitive.ANY)

VIEWS = "_views"
"""The module with the types of a package in IDL, and conversions to those of CDL."""


class IdlService(msgspec.Struct, frozen=True):
    """A service in IDL.

    `declarations` are the types that it needs, in order, then the interface. `arrays` gives the
    typedef inside of the interface for each array that is an `any`, by the parameter's place.
    """

    service: Service
    interface: Interface
    declarations: tuple[Declaration, ...]
    arrays: Mapping[Span, ScopedName]

    @property
    def file(self) -> str:
        """The name of its IDL file."""
        return f"{self.service.name}.idl"


class IdlSide(msgspec.Struct, frozen=True):
    """The IDL of a package's services. `shared` are the declarations that several files use.

    `structs` gives the scoped name in IDL of each struct of CDL, `refused` the spans of
    functions that IDL cannot express.
    """

    model: Model
    services: tuple[IdlService, ...]
    shared: frozenset[ScopedName]
    structs: dict[ScopedName, ScopedName]
    refused: frozenset[Span]


def idl_side(
    package: TecsPackage, communication: Model
) -> tuple[IdlSide, list[Diagnostic]]:
    """The IDL of a package, and diagnostics for functions that have none.

    `communication` has the interface that marshallers use.
    """
    builder = _Builder(package)
    return builder.side(communication), builder.findings


class _Builder:
    def __init__(self, package: TecsPackage) -> None:
        self.findings: list[Diagnostic] = []
        self._refused: set[Span] = set()
        self._package = package
        self._unit = package.unit
        ours = [f"{s.name}{what}" for s in package.services for what in RTCS]
        self._scopes: dict[ScopedName, IdlNames] = {
            (): IdlNames([*COMMUNICATION, *ours])
        }
        self._modules: dict[ScopedName, ScopedName] = {(): ()}
        services = package.services
        self._interfaces = {
            s.signature.name: self._named(s.signature.name[:-1], s.name)
            for s in services
        }
        for declaration in self._unit.declarations:
            self._module(declaration.name[:-1])
        self._structs = {
            d.name: self._named(d.name[:-1], d.name[-1])
            for d in self._unit.declarations
            if isinstance(d, TecsStruct)
        }
        self._typedefs = {
            d.name: self._named(d.name[:-1], d.name[-1])
            for d in self._unit.declarations
            if isinstance(d, TecsTypedef) and self._is_typedef(d)
        }
        self._types = IdlTypes(
            self._unit, services[0].options.widths, self._structs, self._typedefs
        )

    def _is_typedef(self, declaration: TecsTypedef) -> bool:
        """Whether a typedef has one in IDL: not of a kernel type or pointer, no struct's alias."""
        plain = declaration.type
        if isinstance(plain, CStructType):
            name = (
                ".".join(self._structs[plain.tag]) if plain.tag in self._structs else ""
            )
            if name.lower() == ".".join(declaration.name).lower():
                return False
        if declaration.from_c:
            return False
        return not isinstance(resolve(plain), CPointerType)

    def _module(self, scope: ScopedName) -> ScopedName:
        if scope not in self._modules:
            outer = self._module(scope[:-1])
            names = self._scopes.setdefault(outer, IdlNames())
            self._modules[scope] = (*outer, names.add(scope[-1]))
        return self._modules[scope]

    def _named(self, scope: ScopedName, name: str) -> ScopedName:
        module = self._module(scope)
        return (*module, self._scopes.setdefault(module, IdlNames()).add(name))

    def side(self, communication: Model) -> IdlSide:
        declared = {d.name: d for d in self._declarations()}
        services = []
        counts: Counter[ScopedName] = Counter()
        for service in self._package.services:
            anonymous, interface = self._interface(service)
            inner = anonymous.typedefs
            needed = _reachable([*inner, interface], declared)
            constants = self._constants_beside(service, declared)
            own = [d for d in declared.values() if d.name in needed | constants]
            counts.update(declaration.name for declaration in own)
            services.append(
                IdlService(
                    service, interface, (*own, *inner, interface), anonymous.arrays
                )
            )
        return IdlSide(
            self._model(services, counts, communication),
            tuple(services),
            frozenset(name for name, count in counts.items() if count > 1),
            self._structs,
            frozenset(self._refused),
        )

    def _model(
        self,
        services: Sequence[IdlService],
        shared: Collection[ScopedName],
        communication: Model,
    ) -> Model:
        """Return the declarations (outside of interfaces in a file of types) and components."""
        main = replace(self._package.sources[0], includes=())
        types = f"{self._package.stem}-types.idl"
        files = [replace(main, name=types, module=VIEWS, taken=self._in_views())]
        declarations: dict[ScopedName, Declaration] = {}
        for idl in services:
            taken = self._in_marshaller(idl.service)
            module = marshaller_module(idl.service)
            files.append(replace(main, name=idl.file, module=module, taken=taken))
            for declaration in idl.declarations:
                file = types if declaration.name in shared else idl.file
                declarations.setdefault(
                    declaration.name, replace(declaration, file=file)
                )
        components: list[Declaration] = []
        for idl in services:
            components += components_of(idl.service, idl.interface, idl.file)
        return Model(
            files=(*communication.files, *files),
            declarations=(
                *(
                    d
                    for d in communication.declarations
                    if not isinstance(d, Component)
                ),
                *declarations.values(),
                *components,
            ),
        )

    def _in_views(self) -> frozenset[str]:
        """Return the names of conversions in the module of types."""
        structs = [struct_class(name) for name in self._structs]
        functions = (f"{way}_{name}" for way in ("codec", "idl") for name in structs)
        return frozenset(("_types", "value", *functions))

    def _in_marshaller(self, service: Service) -> frozenset[str]:
        """Return the names in the module of a service besides those of its interface."""
        name = identifier(service.name)
        classes = ("Proxy", "Target", *RTCS, *(f"{each}Base" for each in RTCS))
        structs = (struct_class(each) for each in self._structs)
        names = self._in_views().union(
            structs,
            (f"{name}{each}" for each in classes),
            (f"_{name}Servant", codec_class(service.signature)),
            MARSHALLER_NAMES,
            BASE_NAMES,
        )
        return names.difference(HOMES)  # which are imported from the same places

    # Types and constants.

    def _declarations(self) -> Iterator[Declaration]:
        """All declarations of the unit that IDL can express, in order."""
        for declaration in self._unit.declarations:
            lowered: Declaration | None = None
            match declaration:
                case TecsStruct():
                    lowered = self._quietly(self._struct, declaration)
                case TecsTypedef() if declaration.name in self._typedefs:
                    lowered = self._quietly(self._typedef, declaration)
                case TecsConst():
                    lowered = self._const(declaration)
            if lowered is not None:
                yield lowered

    def _quietly(self, make: Callable[[_D], Declaration], of: _D) -> Declaration | None:
        try:
            return make(of)
        except NotInIdlError:
            return None  # reported where a parameter uses it

    def _struct(self, declaration: TecsStruct) -> Struct:
        name = self._structs[declaration.name]
        self._types.type(CStructType(declaration.name))
        names = IdlNames([name[-1]])
        members = tuple(
            Member(
                name=names.add(member.name),
                type=self._types.sized(member.type, member.sizes),
                span=member.span,
                doc=member.doc,
            )
            for member in declaration.members
        )
        return Struct(**common_fields(name, declaration), members=members)

    def _typedef(self, declaration: TecsTypedef) -> Typedef:
        name = self._typedefs[declaration.name]
        return Typedef(
            **common_fields(name, declaration), type=self._types.type(declaration.type)
        )

    def _const(self, declaration: TecsConst) -> Const | None:
        plain = resolve(declaration.type)
        value = declaration.value
        if isinstance(plain, CPointerType) and isinstance(value, str):
            type_: Type = StringType()
        elif isinstance(plain, CScalarType) and value is not None:
            type_ = self._types.type(plain)
        else:
            return None
        name = self._named(declaration.name[:-1], declaration.name[-1])
        fitting = _fitting(type_, plain, value)
        return Const(**common_fields(name, declaration), type=type_, value=fitting)

    def _constants_beside(
        self, service: Service, declared: dict[ScopedName, Declaration]
    ) -> set[ScopedName]:
        """The constants around a signature: of its file, and of the name spaces it is in."""
        scope = self._interfaces[service.signature.name][:-1]
        return {
            d.name
            for d in declared.values()
            if isinstance(d, Const)
            and d.file == service.signature.file
            and scope[: len(d.name) - 1] == d.name[:-1]
        }

    # Interfaces.

    def _interface(self, service: Service) -> tuple[AnonymousTypes, Interface]:
        """The interface, and the types local to it."""
        signature = service.signature
        name = self._interfaces[signature.name]
        operations = IdlNames([name[-1]])
        taken = [operations.add(function.name) for function in signature.functions]
        anonymous = AnonymousTypes(name, signature, IdlNames([name[-1], *taken]))
        interface = Interface(
            **common_fields(name, signature),
            operations=tuple(
                self._operation(service, function, operation, anonymous)
                for function, operation in zip(signature.functions, taken, strict=True)
            ),
        )
        return anonymous, interface

    def _operation(
        self,
        service: Service,
        function: TecsFunction,
        name: str,
        anonymous: AnonymousTypes,
    ) -> Operation:
        names = IdlNames()
        before = len(self.findings)
        try:
            returns = self._types.returns(function.returns)
        except NotInIdlError as reason:
            returns = VOID
            self._complain(f"what {function.name} returns", function.span, reason)
        parameters = []
        for parameter in function.parameters:
            type_ = self._parameter_type(service, parameter, anonymous)
            if type_ is not None:
                parameters.append(
                    Parameter(
                        direction=_DIRECTIONS[parameter.direction],
                        name=names.add(parameter.name),
                        type=type_,
                        span=parameter.span,
                        doc=parameter.doc,
                    )
                )
        if len(self.findings) > before:
            self._refused.add(function.span)
        return Operation(
            name=name,
            returns=anonymous.named(returns),
            parameters=tuple(parameters),
            # A oneway operation of IDL cannot report that its request was written.
            oneway=function.oneway and returns == VOID,
            span=function.span,
            doc=function.doc,
        )

    def _parameter_type(
        self, service: Service, parameter: TecsParameter, anonymous: AnonymousTypes
    ) -> Type | None:
        try:
            type_ = self._types.parameter(parameter)
        except NotInIdlError as reason:
            self._complain(parameter.name, parameter.span, reason)
            return None
        named = anonymous.named(type_)
        if service.options.array == "any" and _is_sized(parameter):
            assert isinstance(named, NamedType)
            anonymous.arrays[parameter.span] = named.name
            return _ANY
        return named

    def _complain(self, what: str, span: Span, reason: NotInIdlError) -> None:
        self.findings.append(
            NOT_IN_IDL.at(
                span, f"{what} has no IDL: {reason}", hint=reason.hint or None
            )
        )


def _is_sized(parameter: TecsParameter) -> bool:
    sizes = parameter.sizes
    return sizes.size_is is not None or sizes.count_is is not None


def _reachable(
    roots: Sequence[Declaration], declared: dict[ScopedName, Declaration]
) -> set[ScopedName]:
    def following(declaration: Declaration) -> Iterator[ScopedName]:
        return (name for name in referred(declaration) if name in declared)

    needed = (name for root in roots for name in following(root))
    return reached(needed, lambda name: following(declared[name]))


def _fitting(type_: Type, plain: object, value: ConstantValue) -> ConstantValue:
    """The value converted for a constant of the IDL type."""
    if type_ == PrimitiveType(Primitive.OCTET) and isinstance(value, int):
        return value & 0xFF
    if type_ == PrimitiveType(Primitive.CHAR) and isinstance(value, int):
        return chr(value & 0xFF)
    if isinstance(plain, CScalarType) and plain.kind is Scalar.BOOL:
        return bool(value)
    if isinstance(plain, CScalarType) and isinstance(value, bool):
        return int(value)
    floating = (PrimitiveType(Primitive.FLOAT), PrimitiveType(Primitive.DOUBLE))
    return float(value) if type_ in floating and isinstance(value, int) else value
