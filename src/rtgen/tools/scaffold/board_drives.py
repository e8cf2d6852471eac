"""How the functions of a TECS board drive the wheels of a base, by their parameters."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Final

import msgspec

from rtgen.compiler.backends.tecs.function_text import (
    LOCALS,
    function_names,
    struct_classes,
)
from rtgen.compiler.backends.tecs.service_text import ServiceText
from rtgen.compiler.diagnostics import InputError
from rtgen.compiler.layouts.tdr import (
    Basic,
    Counted,
    FixedArray,
    FunctionLayout,
    Item,
    Node,
    Record,
    references,
    sizes_of,
)
from rtgen.compiler.layouts.tdr_messages import is_error_code
from rtgen.compiler.lowering.tecs.boards import BoardPackage
from rtgen.compiler.lowering.tecs.plan import RtcJoin
from rtgen.compiler.typemap.tecs.python import member_name, zero
from rtgen.facts.tdr import Scalar
from rtgen.tools.scaffold.rules import NO_DRIVE

_REAL: Final = (Scalar.FLOAT32, Scalar.DOUBLE64)
_WHEELS: Final = 2
_WORDS: Final = ("count", "position", "pos", "angle", "encoder", "enc")
"""Words in the names of members with the counts of encoders."""


class BoardDrive(msgspec.Struct, frozen=True):
    """The function that drives the wheels, and where the counts of encoders come from.

    `getter` is a function for the counts, if `drive` does not have them as results; `limit` one for
    the greatest speed, and perhaps acceleration.
    """

    board: BoardPackage
    join: RtcJoin
    drive: FunctionLayout
    counted: tuple[Item, Item | None]
    getter: FunctionLayout | None
    limit: FunctionLayout | None

    @property
    def name(self) -> str:
        """The name of the service, `MotorBoard`."""
        return self.join.service.name

    @property
    def bits(self) -> int:
        """The width of the counts."""
        item = self.counted[1] or self.counted[0]
        scalar = _numbers(item.node)
        assert scalar is not None
        width = self.join.options.widths.of(scalar)
        if width is not None:
            return width[0]
        digits = "".join(filter(str.isdigit, scalar.value))
        return int(digits) if scalar not in _REAL else 53

    @property
    def values(self) -> dict[str, object]:
        """The variables of templates."""
        methods = self._methods
        getter, limit = "", ""
        results = self._results(self.drive)
        drive = methods[self.drive.function.name]
        given = ", ".join(_arguments(self.drive))
        if self.getter is not None:
            call = f"board.{methods[self.getter.function.name]}()"
            getter = f"{self._results(self.getter)} = {call}"
        if self.limit is not None:
            limits = ["config.max_wheel_speed / unit", "config.max_wheel_acceleration"]
            values = ", ".join(limits[: len(self.limit.arguments)])
            limit = f"board.{methods[self.limit.function.name]}({values})"
        item, member = self.counted
        text = f"{item.name}_" + (
            "" if member is None else f".{member_name(member.name)}"
        )
        return {
            "port": self.join.service.module,
            "drive": drive,
            "drive_call": f"{results + ' = ' if results else ''}board.{drive}({given})",
            "returns_code": is_error_code(self.drive.function.returns),
            "getter": getter,
            "getter_returns_code": self.getter is not None
            and is_error_code(self.getter.function.returns),
            "limit": limit,
            "counts": text,
            "bits": self.bits,
        }

    @property
    def _methods(self) -> dict[str, str]:
        [layout] = [
            each
            for each in self.board.layouts
            if each.signature is self.join.service.signature
        ]
        return function_names(layout)

    def _results(self, layout: FunctionLayout) -> str:
        names = [] if layout.is_void else ["code"]
        names += [f"{i.name}_" if i is self.counted[0] else "_" for i in layout.outs]
        return ", ".join(names)

    def simulated(self, package: str) -> dict[str, object]:
        """Return the variables of the template of the simulated board."""
        [layout] = [
            each
            for each in self.board.layouts
            if each.signature is self.join.service.signature
        ]
        text = ServiceText(self.join.service, layout, package)
        methods = []
        for function in layout.functions:
            method = text.method(function)
            names = text.parameters(function)
            methods.append(
                {
                    "name": method.name,
                    "parameters": method.parameters,
                    "result": method.result,
                    "body": [*self._body(function, names)],
                }
            )
        return {
            "methods": methods,
            "structs": ", ".join(struct_classes(layout)),
            "has_sequences": any("Sequence[" in str(m["parameters"]) for m in methods),
        }

    def _body(self, layout: FunctionLayout, names: dict[str, str]) -> Iterator[str]:
        if layout.function.id == self.drive.function.id:
            wanted = [names[i.name] for i in _commands(layout)]
            both = wanted * _WHEELS if len(wanted) == 1 else wanted
            places = ("[0]", "[1]") if len(wanted) == 1 else ("", "")
            speeds = [f"float({n}{p})" for n, p in zip(both, places, strict=True)]
            yield f"self.speeds = [{', '.join(speeds)}]"
        results = [] if layout.is_void else [zero(layout.returned.node)]
        for item in layout.outs:
            own = self._with_counts(item)
            if own is None:
                results.append("None" if item.nullable else zero(item.node))
                continue
            lines, value = own
            yield from lines
            results.append(value)
        if results:
            yield f"return {', '.join(results)}"
        elif layout.function.id != self.drive.function.id:
            yield "return"

    def _with_counts(self, item: Item) -> tuple[list[str], str] | None:
        """Return the statements and the expression of a result with the counts; None without."""
        found = _counted_in(item)
        if found is None:
            return None
        counts = found[1] or found[0]
        scalar = _numbers(counts.node)
        convert = "float" if scalar in _REAL else "round"
        values = f"[{convert}(each) for each in self.counts]"
        size = counts.node.count if isinstance(counts.node, FixedArray) else _WHEELS
        if isinstance(size, int) and size > _WHEELS:
            values += f" + [{'0.0' if scalar in _REAL else '0'}] * {size - _WHEELS}"
        if found[1] is None:
            return [], values
        local = "result" if item.name in LOCALS else f"{item.name}_"
        member = member_name(found[1].name)
        return [f"{local} = {zero(item.node)}", f"{local}.{member} = {values}"], local


def drive_of(boards: list[BoardPackage]) -> BoardDrive:
    """Return how the first board that can drives two wheels. Raises InputError."""
    known: list[str] = []
    for board in boards:
        layouts = dict(zip(map(id, board.plan.services), board.layouts, strict=True))
        for join in board.plan.joins:
            functions = layouts[id(join.service)].functions
            known += [f.function.name for f in functions]
            found = _drive(board, join, functions)
            if found is not None:
                return found
    message = "no function of a joined signature drives two wheels"
    hint = (
        "it takes both speeds, as two numbers or an array, and it or another one without "
        f"parameters has an array with two counts; there are: {', '.join(known) or 'none'}"
    )
    span = boards[0].plan.joins[0].through.span if boards else None
    raise InputError([NO_DRIVE.at(span, message, hint=hint)])


def _drive(
    board: BoardPackage, join: RtcJoin, functions: tuple[FunctionLayout, ...]
) -> BoardDrive | None:
    limit = next((f for f in functions if _is_limit(f)), None)
    getters = [f for f in functions if not f.arguments and _counted(f) is not None]
    for function in functions:
        if function is limit or not _commands(function):
            continue
        own = _counted(function)
        if own is not None:
            return BoardDrive(board, join, function, own, None, limit)
        if getters:
            counted = _counted(getters[0])
            assert counted is not None
            return BoardDrive(board, join, function, counted, getters[0], limit)
    return None


def _is_limit(function: FunctionLayout) -> bool:
    """Return whether a function takes the greatest speed, and perhaps acceleration."""
    named = "limit" in function.function.name.lower()
    items = function.arguments
    return (
        named
        and 0 < len(items) <= _WHEELS
        and all(
            isinstance(i.node, Basic) and i.node.scalar in _REAL and not i.nullable
            for i in items
        )
    )


def _commands(function: FunctionLayout) -> list[Item]:
    """Return the parameters with the speeds: an array, or two numbers; none for other functions."""
    sizes = _sizes(function)
    items = [i for i in function.arguments if i.name not in sizes]
    if any(i.asked or i.nullable or i.outward for i in items):
        return []
    match items:
        case [Item(node=Counted() | FixedArray()) as array]:
            most = array.node.most if isinstance(array.node, Counted) else None
            if isinstance(array.node, FixedArray):
                most = array.node.count if array.node.count == _WHEELS else 0
            fits = most is None or most >= _WHEELS
            return [array] if fits and _numbers(array.node) is not None else []
        case [Item(node=Basic(one)), Item(node=Basic(two))] if not sizes and one is two:
            return items if one is not Scalar.BOOL else []
    return []


def _sizes(function: FunctionLayout) -> set[str]:
    return {
        name
        for item in function.items
        for expression in sizes_of(item.node)
        for name in references(expression)
    }


def _arguments(function: FunctionLayout) -> Iterator[str]:
    """Yield the arguments of the function that drives."""
    commands = _commands(function)
    sides = iter(("left", "right"))
    for item in function.arguments:
        if item not in commands:
            yield str(_WHEELS)
            continue
        scalar = _numbers(item.node) or (
            item.node.scalar if isinstance(item.node, Basic) else None
        )
        form = "{} / unit" if scalar in _REAL else "round({} / unit)"
        if len(commands) == 1:
            yield f"[{form.format('left')}, {form.format('right')}]"
        else:
            yield form.format(next(sides))


def _counted(function: FunctionLayout) -> tuple[Item, Item | None] | None:
    """Return the result with the counts of encoders, and its member."""
    found = [each for i in function.outs if (each := _counted_in(i)) is not None]
    return found[0] if found else None


def _counted_in(item: Item) -> tuple[Item, Item | None] | None:
    if item.nullable:
        return None
    if _is_pair(item.node):
        return item, None
    if not isinstance(item.node, Record):
        return None
    arrays = [each for each in item.node.items if _is_pair(each.node)]
    named = [a for a in arrays if any(word in a.name.lower() for word in _WORDS)]
    return (item, named[0]) if named else None


def _is_pair(node: Node) -> bool:
    if isinstance(node, FixedArray) and node.count < _WHEELS:
        return False
    return _numbers(node) is not None


def _numbers(node: Node) -> Scalar | None:
    """Return the type of the elements of an array of numbers."""
    match node:
        case FixedArray(Basic(scalar)) | Counted(Basic(scalar)):
            return None if scalar is Scalar.BOOL else scalar
    return None
