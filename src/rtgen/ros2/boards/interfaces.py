"""The services of TECS boards: names, and interface files with what calls carry.

A response begins with `success` and `message`, since a service of ROS 2 has no other errors.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterable, Iterator, Mapping
from pathlib import PurePosixPath
from typing import Final

import msgspec

from rtgen.compiler.backends import Artifact
from rtgen.compiler.backends.kit.python_text import header
from rtgen.compiler.diagnostics import Diagnostic, Related, Span, has_errors
from rtgen.compiler.layouts.ros_types import service_hash, type_hash
from rtgen.compiler.layouts.tdr import FunctionLayout, Item, Record
from rtgen.compiler.lowering.tecs.boards import BoardPackage, boards
from rtgen.compiler.lowering.tecs.plan import RtcJoin, Service
from rtgen.compiler.model import Model, ScopedName, Struct
from rtgen.compiler.typemap.tecs.texts import function_text
from rtgen.facts import ros_names
from rtgen.ros2 import ros_idl
from rtgen.ros2.backend.fields import (
    InexpressibleError,
    field_name,
    message_name,
    package_name,
)
from rtgen.ros2.backend.rules import NOT_IN_ROS, SAME_SERVICE
from rtgen.ros2.boards.types import field_names, item_type
from rtgen.ros2.rosidl.pipeline import load_texts
from rtgen.ros2.rosidl.syntax import MESSAGE_NAME, PACKAGE_NAME

FOLDER: Final = "ros2"
SUCCESS, MESSAGE, RETURNED = "success", "message", "return_value"
"""The first fields of responses: whether the call was made and returned no error, why not, and what
the function returned.
"""
_EVENT_INFO: Final = "service_msgs/msg/ServiceEventInfo"
_SUCCESS_DOC: Final = "The board was called, and returned no error."
_MESSAGE_DOC: Final = "Why not."
_HINT: Final = (
    "put a struct around the inner one; [ros2] boards = false writes no services"
)


class BoardService(msgspec.Struct, frozen=True):
    """A function of a joined signature as a service.

    `name` is relative to the namespace (`board/drive`), `interface` is as in `lab/srv/ArmMove`.
    `arguments` and `results` are pairs of an item of the layout and its field.
    """

    name: str
    interface: str
    join: RtcJoin
    layout: FunctionLayout
    arguments: tuple[tuple[Item, str], ...]
    results: tuple[tuple[Item, str], ...]

    @property
    def place(self) -> Span:
        """The place of the function."""
        return self.layout.function.span


class Interfaces(msgspec.Struct, frozen=True):
    """The services of the boards of one CDL file.

    `texts` are the interface files by name; `model` has the messages, and `hashes` the hash of each
    interface; `messages` are those of structs, by their names in CDL.
    """

    board: BoardPackage
    services: tuple[BoardService, ...]
    texts: Mapping[str, str]
    model: Model
    hashes: Mapping[str, str]
    messages: Mapping[ScopedName, str]
    findings: tuple[Diagnostic, ...]

    @property
    def origin(self) -> tuple[str, ...]:
        """The keys of the inputs."""
        return tuple(source.key for source in self.board.sources)


def interfaces(model: Model, package: str) -> list[Interfaces]:
    """Return the services of all boards; `package` is the project's Python package."""
    seen: dict[str, BoardService] = {}
    return [_Writer(board, package, seen).interfaces() for board in boards(model)]


def of_board(board: BoardPackage, package: str) -> Interfaces:
    """Return the services of one CDL file."""
    return _Writer(board, package, {}).interfaces()


def service_facts(
    files: Iterable[Interfaces], namespace: str
) -> Iterator[dict[str, str]]:
    """Yield name, type, hash and function of each service, as `rtgen inspect` shows them."""
    for each in files:
        for service in each.services:
            signature = service.join.service.signature
            yield {
                "name": ros_names.qualified(service.name, namespace),
                "type": service.interface,
                "hash": each.hashes[service.interface],
                "function": f"{signature.scoped}.{service.layout.function.name}",
                "join": service.join.path,
            }


def artifacts(
    interfaces: Interfaces, namespace: str, version: str
) -> Iterator[Artifact]:
    """Yield interface files, which state names and hashes, and the same as IDL."""
    for name, text in interfaces.texts.items():
        path = PurePosixPath(name)
        interface = path.with_suffix("").as_posix()
        lines = [
            *header(version, interfaces.origin),
            *_about(interfaces, interface, namespace),
        ]
        head = "".join(f"# {line}\n" for line in lines)
        yield Artifact(f"{FOLDER}/{name}", f"{head}\n{text}", interfaces.origin)
        idl = path.with_suffix(".idl").as_posix()
        head = "".join(f"// {line}\n" for line in lines)
        body = ros_idl.plain_idl_of(interfaces.model, idl)
        yield Artifact(f"{FOLDER}/{idl}", f"{head}\n{body}", interfaces.origin)


def _about(interfaces: Interfaces, interface: str, namespace: str) -> Iterator[str]:
    for service in interfaces.services:
        if service.interface == interface:
            yield f"Service {ros_names.qualified(service.name, namespace)}"
    yield f"Type {interface}, {interfaces.hashes[interface]}"


class _Writer:
    def __init__(
        self, board: BoardPackage, package: str, seen: dict[str, BoardService]
    ) -> None:
        self._board = board
        self._seen = seen
        self._package = package_name((*package.split("."), board.plan.stem))
        self._texts: dict[str, str] = {}
        self._findings: list[Diagnostic] = []
        self._records: dict[str, Record | None] = {}
        """Structs with a message, by its name; None: ROS 2 cannot express it."""
        self._services: list[BoardService] = []

    def interfaces(self) -> Interfaces:
        plan = self._board.plan
        described: dict[tuple[int, int], BoardService | None] = {}
        prefixes = _prefixes(plan.stem, plan.joins)
        if not PACKAGE_NAME.fullmatch(self._package):
            message = f"{plan.unit.file} has no services of ROS 2: {self._package!r} is no package"
            hint = "name [output] package, or the file, by letters, digits and single _"
            self._findings.append(
                NOT_IN_ROS.at(plan.joins[0].through.span, message, hint=hint)
            )
            return self._result()
        layouts = dict(zip(map(id, plan.services), self._board.layouts, strict=True))
        for join, prefix in zip(plan.joins, prefixes, strict=True):
            for layout in layouts[id(join.service)].functions:
                key = id(join.service), layout.function.id
                if key not in described:
                    described[key] = self._described(join, layout)
                service = described[key]
                if service is not None:
                    self._add(join, prefix, service)
        return self._result()

    def _result(self) -> Interfaces:
        result = load_texts(self._texts, (_EVENT_INFO,))
        assert not has_errors(result.diagnostics), result.diagnostics
        return Interfaces(
            self._board,
            tuple(self._services),
            self._texts,
            result.model,
            dict(_hashes(result.model, self._texts)),
            {
                record.struct.name: f"{self._package}/msg/{name}"
                for name, record in self._records.items()
                if record is not None
            },
            tuple(self._findings),
        )

    def _add(self, join: RtcJoin, prefix: str, first: BoardService) -> None:
        """Add a function's service of a join, unless its name is invalid or taken."""
        name = f"{prefix}/{field_name(first.layout.function.name)}"
        service = msgspec.structs.replace(first, name=name, join=join)
        why = ros_names.violation(name)
        other = self._seen.setdefault(name, service)
        if why is not None:
            message = f"{name} is no name of a service, which {why}"
            hint = "rename the CDL file, the cell or the function"
            self._findings.append(SAME_SERVICE.at(first.place, message, hint=hint))
        elif other is not service:
            self._findings.append(
                SAME_SERVICE.at(
                    first.place,
                    f"{_shown(join, first)} and {_shown(other.join, other)} would both be the "
                    f"service {name}",
                    related=[Related(other.place, "the other is here")],
                    hint="rename one of them, or the CDL file",
                )
            )
        else:
            self._services.append(service)

    def _described(self, join: RtcJoin, layout: FunctionLayout) -> BoardService | None:
        """Write the file of a function; return None if ROS 2 cannot express it."""
        service, function = join.service, layout.function
        name = message_name(f"{service.name}_{function.name}")
        interface = f"{self._package}/srv/{name}"
        file = f"{interface}.srv"
        arguments = [i for i in layout.items if i.inward]
        results = [i for i in layout.items if i.outward]
        where = function.span
        try:
            if not MESSAGE_NAME.fullmatch(name):
                raise InexpressibleError(f"the name {name}")
            if file in self._texts:
                raise InexpressibleError(f"a second {name}")
            given = field_names((i.name for i in arguments), ())
            taken = (SUCCESS, MESSAGE, RETURNED)
            returned = field_names((i.name for i in results), taken)
            lines = list(_comment(function.doc or function_text(function)))
            for item in arguments:
                where = item.span
                lines.append(self._field(item, given[item.name], service))
            lines += ["---", _line("bool", SUCCESS, _SUCCESS_DOC)]
            lines.append(_line("string", MESSAGE, _MESSAGE_DOC))
            if not layout.is_void:
                where = function.span
                lines.append(self._field(layout.returned, RETURNED, service))
            for item in results:
                where = item.span
                lines.append(self._field(item, returned[item.name], service))
        except InexpressibleError as error:
            shown = f"{service.signature.scoped}.{function.name}"
            message = f"{shown} has no service of ROS 2, which does not have {error}"
            self._findings.append(NOT_IN_ROS.at(where, message, hint=_HINT))
            return None
        self._texts[file] = "\n".join(lines) + "\n"
        pairs = [(i, returned[i.name]) for i in results]
        if not layout.is_void:
            pairs.insert(0, (layout.returned, RETURNED))
        return BoardService(
            "",
            interface,
            join,
            layout,
            tuple((i, given[i.name]) for i in arguments),
            tuple(pairs),
        )

    def _field(self, item: Item, name: str, service: Service) -> str:
        widths = service.options.widths
        type_ = item_type(item, widths, lambda record: self._message(record, service))
        parameters = (p for f in service.signature.functions for p in f.parameters)
        docs = {p.span: p.doc for p in parameters}
        return _line(type_, name, docs.get(item.span, ""))

    def _message(self, record: Record, service: Service) -> str:
        """Write the message of a struct; return its name. Raises InexpressibleError."""
        name = message_name("_".join(record.struct.name))
        reference = f"{self._package}/{name}"
        if not MESSAGE_NAME.fullmatch(name):
            raise InexpressibleError(f"the name {record.struct.scoped}")
        if name in self._records:
            known = self._records[name]
            if known is None or known.struct.name != record.struct.name:
                raise InexpressibleError(f"the struct {record.struct.scoped}")
            return reference
        self._records[name] = None
        lines = list(_comment(record.struct.doc))
        names = field_names((item.name for item in record.items), ())
        docs = {m.span: m.doc for m in record.struct.members}
        for item in record.items:
            type_ = item_type(
                item, service.options.widths, lambda r: self._message(r, service)
            )
            lines.append(_line(type_, names[item.name], docs.get(item.span, "")))
        self._records[name] = record
        self._texts[f"{self._package}/msg/{name}.msg"] = "\n".join(lines) + "\n"
        return reference


def _line(type_: str, name: str, doc: str) -> str:
    words = " ".join(doc.split())
    return f"{type_} {name}{f'  # {words}' if words else ''}"


def _prefixes(stem: str, joins: Iterable[RtcJoin]) -> list[str]:
    """Return what names of services begin with: the CDL file, and the cell if it has several joins.

    Of cells that occur more than once the port, and its subscript, follow.
    """
    first = field_name(stem)
    several = list(joins)
    if len(several) == 1:
        return [first]
    cells = [field_name(join.join.target[-1]) for join in several]
    counts = Counter(cells)
    prefixes = []
    for cell, join in zip(cells, several, strict=True):
        words = [cell]
        if counts[cell] > 1:
            words.append(field_name(join.join.target_port))
            if join.join.target_index is not None:
                words[-1] += f"_{join.join.target_index}"
        prefixes.append("/".join((first, *words)))
    return prefixes


def _hashes(model: Model, names: Iterable[str]) -> Iterator[tuple[str, str]]:
    for each in names:
        name = each.rpartition(".")[0]
        package, kind, last = name.split("/")
        if kind == "msg":
            message = model.find((package, kind, last))
            assert isinstance(message, Struct)
            yield name, type_hash(model, message)
            continue
        request, response = (
            model.find((package, kind, f"{last}_{end}"))
            for end in ("Request", "Response")
        )
        assert isinstance(request, Struct)
        assert isinstance(response, Struct)
        yield name, service_hash(model, request, response)


def _comment(doc: str) -> Iterator[str]:
    yield from (f"# {line}".rstrip() for line in doc.splitlines())
    if doc:
        yield ""


def _shown(join: RtcJoin, service: BoardService) -> str:
    function = f"{join.service.signature.scoped}.{service.layout.function.name}"
    return f"{function} of {join.path}"
