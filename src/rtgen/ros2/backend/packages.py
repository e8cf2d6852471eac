"""Packages of interface files: `PACKAGE/msg/Name.msg`, `PACKAGE/srv/Name.srv`, and what they need.

A module is a package, a struct a message, an operation a service; structs with the names of ROS 2
(`lab::msg::Place`, `lab::srv::Find_Request`) are in the interfaces of these names. Of files that
are only included, structs are written that these contain. Declarations that ROS 2 cannot express
are reported and omitted, with those that contain them.
"""

from __future__ import annotations

from collections.abc import Iterable, Sequence

import msgspec

from rtgen.compiler.diagnostics import Diagnostic
from rtgen.compiler.model import (
    Const,
    Declaration,
    Interface,
    Member,
    Model,
    Operation,
    Parameter,
    PrimitiveType,
    ScopedName,
    Struct,
)
from rtgen.facts.primitives import Primitive
from rtgen.facts.ros import is_interface
from rtgen.ros2.backend.fields import message_name, package_of
from rtgen.ros2.backend.rules import NOT_IN_ROS
from rtgen.ros2.backend.texts import Lines, PlacedError
from rtgen.ros2.rosidl.interfaces import DERIVED, PARTS
from rtgen.ros2.rosidl.packages import is_shipped
from rtgen.ros2.rosidl.syntax import MESSAGE_NAME, PACKAGE_NAME

_RESULT = "return_value"
_SEPARATOR = "---"
_BESIDE = {
    "srv": ("service_msgs",),
    "action": (
        "action_msgs",
        "builtin_interfaces",
        "service_msgs",
        "unique_identifier_msgs",
    ),
}
"""Packages whose messages rosidl adds to an interface."""


class InterfaceText(msgspec.Struct, frozen=True, kw_only=True):
    """An interface file: its path (`lab/msg/Place.msg`) and text.

    `file` is the displayed name of the file that declares it, `key` its key. `packages` are those
    that it needs.
    """

    path: str
    text: str
    file: str
    key: str
    packages: frozenset[str]

    @property
    def package(self) -> str:
        """The package that it belongs to."""
        return self.path.partition("/")[0]


def interface_texts(
    model: Model,
) -> tuple[list[InterfaceText], list[Diagnostic]]:
    """Return the interface files of a model, and a warning for each omitted declaration."""
    writer = _Writer(model)
    writer.write()
    return [*writer.texts.values()], writer.findings


class _Writer:
    def __init__(self, model: Model) -> None:
        self._model = model
        self._keys = {file.name: file.key for file in model.files}
        self._main = {file.name for file in model.files if file.main}
        self.findings: list[Diagnostic] = []
        self.texts: dict[str, InterfaceText] = {}
        self._written: dict[ScopedName, bool] = {}
        """Structs by name: whether they have a message, False until that is known."""
        self._interfaces = self._own_interfaces()
        self._constants: dict[ScopedName, list[Const]] = {}
        for each in model.declarations:
            if isinstance(each, Const) and each.name[-2:-1]:
                self._constants.setdefault(each.name[:-1], []).append(each)

    def _own_interfaces(self) -> dict[ScopedName, dict[str, Struct]]:
        """Return the parts of interfaces (`lab`, `srv`, `Find`) in the project's own packages."""
        structs = [
            d
            for d in self._model.declarations
            if isinstance(d, Struct) and is_interface(d.name)
        ]
        own = {d.name[0] for d in structs if d.file in self._main}
        interfaces: dict[ScopedName, dict[str, Struct]] = {}
        for struct in structs:
            package, kind, name = struct.name
            if package not in own or is_shipped(self._keys[struct.file]):
                continue
            stem, mark, rest = name.partition("_" if kind != "msg" else "\0")
            if mark + rest not in DERIVED:
                parts = interfaces.setdefault((package, kind, stem), {})
                parts[mark + rest] = struct
        return interfaces

    def write(self) -> None:
        """Write all; the results are `texts` and `findings`."""
        for declaration in self._model.declarations:
            if declaration.file in self._main:
                self._declaration(declaration)
        for name, parts in self._interfaces.items():
            if name[1] == "msg":
                self._has_message(name)
            else:
                self._interface(name, parts)

    def _declaration(self, declaration: Declaration) -> None:
        if is_interface(declaration.name):
            return
        if isinstance(declaration, Struct):
            self._has_message(declaration.name)
        elif isinstance(declaration, Interface):
            for operation in declaration.operations:
                self._service(declaration, operation)

    def _has_message(self, name: ScopedName) -> bool:
        """Return whether a struct has a message, which is written first if necessary."""
        if is_interface(name) and name not in self._interfaces:
            return name[1] == "msg"
        if name not in self._written:
            self._written[name] = False
            struct = self._model.find(name)
            assert isinstance(struct, Struct)
            self._written[name] = self._message(struct)
        return self._written[name]

    def _message(self, struct: Struct) -> bool:
        used: set[str] = set()
        try:
            lines = self._lines_of(struct, used)
            self._add(struct.name, "msg", lines, used, struct)
        except PlacedError as error:
            self._report(error, struct.scoped, struct)
            return False
        return True

    def _interface(self, name: ScopedName, parts: dict[str, Struct]) -> None:
        """Write a service or an action whose messages are structs."""
        first = next(iter(parts.values()))
        used: set[str] = set()
        lines: list[str] = []
        try:
            for number, suffix in enumerate(PARTS[name[1]]):
                if suffix not in parts:
                    what = f"{name[1]} files without {name[2]}{suffix}"
                    raise PlacedError(first.span, what)
                lines += [_SEPARATOR] if number else []
                lines += self._lines_of(parts[suffix], used)
            self._add(name, name[1], lines, used, first)
        except PlacedError as error:
            self._report(error, "::".join(name), first)

    def _service(self, interface: Interface, operation: Operation) -> None:
        name = (*interface.name[:-1], f"{interface.name[-1]}_{operation.name}")
        arguments = [*map(_member, operation.arguments)]
        results = [*map(_member, operation.results)]
        if operation.returns != PrimitiveType(Primitive.VOID):
            result = Member(span=operation.span, name=_RESULT, type=operation.returns)
            results.insert(0, result)
        used: set[str] = set()
        try:
            if operation.raises:
                raise PlacedError(operation.span, "exceptions")
            lines = [
                *self._lines(arguments, (), operation.doc, used, exact=False),
                _SEPARATOR,
                *self._lines(results, (), "", used, exact=False),
            ]
            self._add(name, "srv", lines, used, interface)
        except PlacedError as error:
            self._report(error, f"{interface.scoped}::{operation.name}", interface)

    def _lines_of(self, struct: Struct, used: set[str]) -> list[str]:
        """Return the lines of a message, with its constants: those of rosidl's module for them."""
        module = (*struct.name[:-1], f"{struct.name[-1]}_Constants")
        constants = self._constants.get(module, ())
        exact = is_interface(struct.name)
        members = self._model.members(struct)
        return self._lines(members, constants, struct.doc, used, exact=exact)

    def _lines(
        self,
        members: Sequence[Member],
        constants: Iterable[Const],
        doc: str,
        used: set[str],
        *,
        exact: bool,
    ) -> list[str]:
        """Return the lines of a part of an interface, and add the packages that it uses."""

        def written(name: ScopedName) -> bool:
            used.add(package_of(name))
            return self._has_message(name)

        return [*Lines(self._model, written, exact=exact).of(members, constants, doc)]

    def _add(
        self,
        name: ScopedName,
        kind: str,
        lines: Sequence[str],
        used: set[str],
        of: Declaration,
    ) -> None:
        package, stem = package_of(name), name[-1]
        stem = stem if is_interface(name) else message_name(stem)
        if not PACKAGE_NAME.fullmatch(package) or len(package) < 2:
            raise PlacedError(of.span, f"packages with the name {package}")
        if not MESSAGE_NAME.fullmatch(stem):
            raise PlacedError(of.span, f"interfaces with the name {stem}")
        path = f"{package}/{kind}/{stem}.{kind}"
        if path in self.texts:
            raise PlacedError(of.span, f"a second {package}/{stem}")
        self.texts[path] = InterfaceText(
            path=path,
            text="\n".join(lines) + "\n",
            file=of.file,
            key=self._keys[of.file],
            packages=frozenset({*used, *_BESIDE.get(kind, ())} - {package}),
        )

    def _report(self, error: PlacedError, what: str, of: Declaration) -> None:
        place = f"{what}::{error.part}" if error.part else what
        message = f"{place} has no form in ROS 2, which does not have {error}"
        if error.part:
            message += f": {what} is left out"
        self.findings.append(NOT_IN_ROS.at(error.span or of.span, message))


def _member(parameter: Parameter) -> Member:
    return Member(span=parameter.span, name=parameter.name, type=parameter.type)
