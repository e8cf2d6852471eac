"""Writes ROS 2 interface files: `ros2/PACKAGE/msg/Name.msg`, `ros2/PACKAGE/srv/Name.srv`.

A module is a package, a struct a message, an operation a service. Of files that are only included,
structs are written that these contain. Declarations that ROS 2 cannot express are reported and
omitted, with those that contain them. The octets are those of the IDL
types in CDR.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence

from rtgen.compiler.backends import Artifact, Emission, Options
from rtgen.compiler.diagnostics import Diagnostic, Span
from rtgen.compiler.model import (
    Enum,
    Interface,
    Member,
    Model,
    NamedType,
    Operation,
    PrimitiveType,
    ScopedName,
    Struct,
    Type,
)
from rtgen.facts.primitives import Primitive
from rtgen.facts.ros import is_interface
from rtgen.ros2.backend.fields import (
    InexpressibleError,
    field_name,
    field_type,
    message_name,
    package_name,
)
from rtgen.ros2.backend.rules import NOT_IN_ROS

_FOLDER = "ros2"
_RESULT = "return_value"


class RosInterfacesBackend:
    """Writes a file for each struct and each operation, if `[ros2] interfaces` is set."""

    name = "ros-interfaces"

    def emit(self, model: Model, options: Options) -> Emission:
        """Return the files, and a warning for each omitted declaration."""
        return _Writer(model).emission()


BACKEND = RosInterfacesBackend()


class _Writer:
    def __init__(self, model: Model) -> None:
        self._model = model
        self._keys = {file.name: file.key for file in model.files}
        self._main = {file.name for file in model.files if file.main}
        self._findings: list[Diagnostic] = []
        self._artifacts: dict[str, Artifact] = {}
        self._written: dict[ScopedName, bool] = {}
        """Structs by name: whether they have a message, False until that is known."""

    def emission(self) -> Emission:
        for declaration in self._model.declarations:
            if declaration.file not in self._main:
                continue
            if isinstance(declaration, Struct):
                self._has_message(declaration.name)
            elif isinstance(declaration, Interface) and not is_interface(
                declaration.name
            ):
                for operation in declaration.operations:
                    self._service(declaration, operation)
        return Emission(tuple(self._artifacts.values()), tuple(self._findings))

    def _has_message(self, name: ScopedName) -> bool:
        """Return whether a struct has a message, which is written first if necessary."""
        if is_interface(name):
            return name[1] == "msg"
        if name not in self._written:
            self._written[name] = False
            struct = self._model.find(name)
            assert isinstance(struct, Struct)
            self._written[name] = self._message(struct)
        return self._written[name]

    def _message(self, struct: Struct) -> bool:
        try:
            lines = [*self._lines([*self._members(struct)], struct.doc)]
            self._add(struct.name, "msg", lines, struct.file)
        except _At as error:
            self._report(error, struct.scoped, "message")
            return False
        return True

    def _service(self, interface: Interface, operation: Operation) -> None:
        name = (*interface.name[:-1], f"{interface.name[-1]}_{operation.name}")
        arguments = [p for p in operation.parameters if p.direction != "out"]
        taken = [p for p in operation.parameters if p.direction != "in"]
        try:
            if operation.raises:
                raise _At(operation.span, "exceptions")
            request = self._lines(
                [_member(p.name, p.type, p.span) for p in arguments], operation.doc
            )
            results = [_member(p.name, p.type, p.span) for p in taken]
            if operation.returns != PrimitiveType(Primitive.VOID):
                results.insert(0, _member(_RESULT, operation.returns, operation.span))
            lines = [*request, "---", *self._lines(results, "")]
            self._add(name, "srv", lines, interface.file)
        except _At as error:
            self._report(error, f"{interface.scoped}::{operation.name}", "service")

    def _members(self, struct: Struct) -> Iterator[Member]:
        if struct.base is not None:
            base = self._model.find(struct.base)
            assert isinstance(base, Struct)
            yield from self._members(base)
        yield from struct.members

    def _lines(self, members: Sequence[Member], doc: str) -> Iterator[str]:
        """Yield comment, constants of enums, and fields. Raises _At."""
        if doc:
            yield from (f"# {line}".rstrip() for line in doc.splitlines())
            yield ""
        names: set[str] = set()
        constants: list[str] = []
        fields: list[str] = []
        for member in members:
            name = field_name(member.name)
            if name in names or not name or name[0].isdigit():
                raise _At(member.span, f"the name {member.name} beside the others")
            names.add(name)
            try:
                type_ = field_type(self._model, member.type, self._has_message)
            except InexpressibleError as error:
                raise _At(member.span, str(error)) from None
            if member.optional:
                raise _At(member.span, "optional members")
            fields.append(f"{type_} {name}{_comment(member)}")
            constants += self._constants(name, member.type)
        yield from constants
        yield from ("",) if constants else ()
        yield from fields

    def _constants(self, name: str, type_: Type) -> Iterator[str]:
        plain = self._model.unalias(type_)
        declaration = (
            self._model.find(plain.name) if isinstance(plain, NamedType) else None
        )
        if isinstance(declaration, Enum):
            for each in declaration.members:
                key = f"{name}_{field_name(each.name)}".upper()
                yield f"uint32 {key}={each.value}"

    def _add(self, name: ScopedName, kind: str, lines: list[str], file: str) -> None:
        package, message = package_name(name[:-1]), message_name(name[-1])
        path = f"{_FOLDER}/{package}/{kind}/{message}.{kind}"
        if path in self._artifacts:
            raise _At(None, f"a second {package}/{message}")
        text = "\n".join(lines) + "\n"
        self._artifacts[path] = Artifact(path, text, (self._keys[file],))

    def _report(self, error: _At, what: str, form: str) -> None:
        message = f"{what} has no {form} of ROS 2, which does not have {error}"
        self._findings.append(NOT_IN_ROS.at(error.span, message))


class _At(Exception):  # noqa: N818 - a place, not only an error
    def __init__(self, span: Span | None, what: str) -> None:
        super().__init__(what)
        self.span = span


def _member(name: str, type_: Type, span: Span) -> Member:
    return Member(span=span, name=name, type=type_)


def _comment(member: Member) -> str:
    text = " ".join(member.doc.split())
    unit = member.annotation("unit")
    if unit is not None and "[" not in text:
        text = f"{text} [{dict(unit.arguments)['value']}]".strip()
    return f"  # {text}" if text else ""
