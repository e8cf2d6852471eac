"""Users affected by changes: the parts of the project that use what has changed."""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Iterable, Iterator, Mapping
from dataclasses import dataclass, field

from rtgen.compiler.model import (
    ArrayType,
    Component,
    Interface,
    MapType,
    Model,
    NamedType,
    SequenceType,
    System,
    Type,
    Typedef,
)
from rtgen.compiler.model.c_types import CArrayType, CPointerType, CStructType, resolve
from rtgen.compiler.model.tecs import Cell, Celltype, Signature
from rtgen.tools.diff.changes import Break, Change, User
from rtgen.tools.diff.versions import Version

_KINDS = (
    *("type", "operation", "component", "port", "instance", "connection", "system"),
    *("signature", "celltype", "cell", "join", "node", "link"),
)
"""Kinds of users, in the order of messages."""


@dataclass(slots=True)
class Users:
    """Users of types, interfaces, components, signatures and devices, by name."""

    direct: dict[str, set[User]] = field(default_factory=lambda: defaultdict(set))

    def of(self, name: str) -> set[User]:
        """Return all direct and indirect users of a name."""
        seen: set[User] = set()
        waiting = [name]
        while waiting:
            for user in self.direct.get(waiting.pop(), ()):
                if user not in seen:
                    seen.add(user)
                    waiting.append(user.name)
        return seen


def users_of(versions: Iterable[Version]) -> Users:
    """Return the users in all versions: a removed item was used in the old one."""
    users = Users()
    for version in versions:
        models = [version.model, *(p.model for p in version.model.packages)]
        for model in models:
            _of_interfaces(model, users)
            _of_components(model, users)
        for system in version.model.systems:
            _of_system(system, users)
        _of_boards(version.model, users)
        _of_buses(version.model, users)
    return users


def with_users(changes: Iterable[Change], users: Users) -> Iterator[Change]:
    """Yield the changes with their users; compatible changes have none."""
    for each in changes:
        if each.classes == (Break.COMPATIBLE,):
            yield each._replace(users=())
            continue
        found = set(each.users)
        for user in each.users:
            found |= users.of(user.name)
        for name in _names_of(each):
            found |= users.of(name)
        own = {each.subject, each.subject.partition(".")[0]}
        listed = (u for u in found if u.kind == "type" or u.name not in own)
        order = sorted(listed, key=lambda u: (_KINDS.index(u.kind), u.name))
        yield each._replace(users=tuple(order))


_PORT_CODES = "DIF032"
"""Prefix of the codes of changes of ports, which only break connections of the port."""


def _names_of(each: Change) -> Iterator[str]:
    """Yield the names by which users refer to the subject: its own, and those of its parents."""
    subject = each.subject.partition("(")[0]
    yield subject
    if "." in subject and not each.kind.code.startswith(_PORT_CODES):
        yield subject.rpartition(".")[0]


def _of_interfaces(model: Model, users: Users) -> None:
    for interface in model.declarations:
        if not isinstance(interface, Interface):
            continue
        for operation in interface.operations:
            user = User("operation", f"{interface.scoped}.{operation.name}")
            for type_ in (operation.returns, *(p.type for p in operation.parameters)):
                for name in _named(type_, model):
                    users.direct[name].add(user)
        for base in interface.bases:
            users.direct["::".join(base)].add(User("type", interface.scoped))


def _of_components(model: Model, users: Users) -> None:
    for component in model.declarations:
        if not isinstance(component, Component):
            continue
        for port in component.ports:
            user = User("port", f"{component.scoped}.{port.name}")
            for name in _named(port.type, model):
                users.direct[name].add(user)


def _named(type_: Type, model: Model) -> Iterator[str]:
    """Yield the names in a type expression, including those of typedefs."""
    match type_:
        case NamedType(name):
            yield "::".join(name)
            try:
                declaration = model.find(name)
            except KeyError:
                return
            if isinstance(declaration, Typedef):
                yield from _named(declaration.type, model)
        case SequenceType(element) | ArrayType(element):
            yield from _named(element, model)
        case MapType(key, value):
            yield from _named(key, model)
            yield from _named(value, model)


def _of_system(system: System, users: Users) -> None:
    types: Mapping[str, str] = {c.instance: c.type for c in system.components}
    for instance, component in types.items():
        users.direct[component].add(User("instance", f"{system.name}:{instance}"))
        whole = User("system", system.name)
        users.direct[f"{system.name}:{instance}"].add(whole)
    for connection in system.connections:
        name = f"{system.name}:{connection.source}-{connection.target}"
        for end in (connection.source, connection.target):
            component = types.get(end.instance, "")
            users.direct[f"{component}.{end.port}"].add(User("connection", name))
            users.direct[f"{system.name}:{end.instance}"].add(User("connection", name))


def _of_boards(model: Model, users: Users) -> None:
    for unit in model.tecs:
        for declaration in unit.declarations:
            if isinstance(declaration, Signature):
                for tag in _structs(declaration):
                    users.direct[tag].add(User("signature", declaration.scoped))
            elif isinstance(declaration, Celltype):
                for port in declaration.ports:
                    signature = "::".join(port.signature)
                    users.direct[signature].add(User("celltype", declaration.scoped))
            elif isinstance(declaration, Cell):
                celltype = "::".join(declaration.celltype)
                users.direct[celltype].add(User("cell", declaration.scoped))


def _structs(signature: Signature) -> Iterator[str]:
    """Yield the tags of the structs that functions of a signature transfer."""
    for function in signature.functions:
        for type_ in (function.returns, *(p.type for p in function.parameters)):
            inner = resolve(type_)
            while isinstance(inner, CPointerType | CArrayType):
                inner = resolve(
                    inner.target if isinstance(inner, CPointerType) else inner.element
                )
            if isinstance(inner, CStructType):
                yield "::".join(inner.tag)


def _of_buses(model: Model, users: Users) -> None:
    for bus in model.buses:
        for node in bus.nodes:
            user = User("node", f"{bus.name}.{node.name}")
            users.direct[bus.name].add(user)
            described = node.kind.described or node.kind.device
            users.direct[described.name].add(user)
            for pdo in node.device.pdos:
                name = f"{described.name}.{pdo.direction}{pdo.number}"
                users.direct[name].add(user)
        for link in bus.links:
            name = f"{bus.name}.{link.source[0]}.{link.source[1]}-{link.target[0]}.{link.target[1]}"
            for end in (link.source, link.target):
                users.direct[f"{bus.name}.{end[0]}"].add(User("link", name))
