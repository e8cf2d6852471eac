"""The lines of a message: comments, constants and fields."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator, Sequence

from rtgen.compiler.diagnostics import Span
from rtgen.compiler.model import (
    Const,
    Enum,
    EnumeratorName,
    InitialValue,
    Member,
    Model,
    ScopedName,
    Type,
)
from rtgen.compiler.model.initial import default_of
from rtgen.compiler.typemap.member_units import annotated_unit, unit_in
from rtgen.ros2.backend.fields import (
    Form,
    InexpressibleError,
    field_name,
    form_of,
    free_name,
    is_reserved,
)
from rtgen.ros2.backend.literals import comment, literal
from rtgen.ros2.rosidl.lowering import FILLER
from rtgen.ros2.rosidl.syntax import CONSTANT_NAME, FIELD_NAME


class PlacedError(Exception):
    """A part of a declaration that ROS 2 cannot express, with its place and its name, if any."""

    def __init__(self, span: Span | None, what: str, part: str = "") -> None:
        super().__init__(what)
        self.span = span
        self.part = part


class Lines:
    """The lines of one message. `exact`: names and types of its fields are those of ROS 2."""

    def __init__(
        self, model: Model, written: Callable[[ScopedName], bool], *, exact: bool
    ) -> None:
        self._model = model
        self._written = written
        self._exact = exact
        self._names: set[str] = set()

    def of(
        self, members: Sequence[Member], constants: Iterable[Const], doc: str
    ) -> Iterator[str]:
        """Yield them. Raises PlacedError."""
        if doc:
            yield from _comment_lines(doc)
            yield ""
        # rosidl adds the filler again.
        real = [m for m in members if m.name != FILLER]
        if self._exact and not members:
            raise PlacedError(None, "messages without the member that rosidl adds")
        fields = [line for member in real for line in self._field(member)]
        own = [line for each in constants for line in self._constant(each)]
        own += [line for member in real for line in self._enumerators(member)]
        yield from own
        yield from ("",) if own and fields else ()
        yield from fields

    def _take(self, name: str, member: Member | Const, shown: str) -> None:
        if name in self._names:
            what = f"the name {shown} beside the others"
            raise PlacedError(member.span, what, shown)
        self._names.add(name)

    def _field(self, member: Member) -> Iterator[str]:
        name = member.name
        if not self._exact:
            name = free_name(field_name(name))
        if not FIELD_NAME.fullmatch(name):
            raise PlacedError(member.span, f"the name {member.name}", member.name)
        self._take(name, member, member.name)
        try:
            if is_reserved(name):
                what = f"the name {name}, a word of C++ or Python"
                raise InexpressibleError(what)
            if member.optional:
                raise InexpressibleError("optional members")
            form = self._form(member.type)
            default = self._default(member, form)
        except InexpressibleError as error:
            raise PlacedError(member.span, str(error), member.name) from None
        above, beside = _comments(member)
        yield from above
        yield f"{form.text} {name}{default}{beside}"

    def _form(self, type_: Type) -> Form:
        return form_of(self._model, type_, self._written, exact=self._exact)

    def _default(self, member: Member, form: Form) -> str:
        initial = default_of(self._model, member.type, member.initial)
        if initial is None:
            return ""
        if not form.has_default:
            raise InexpressibleError("defaults of messages")
        return f" {self._literal(initial, form)}"

    def _literal(self, value: InitialValue, form: Form) -> str:
        values = value if isinstance(value, tuple) else (value,)
        known = [
            (
                self._model.enumerator(each.name).value
                if isinstance(each, EnumeratorName)
                else each
            )
            for each in values
        ]
        try:
            return literal(
                tuple(known) if isinstance(value, tuple) else known[0],
                form.kind,
                form.bound,
            )
        except ValueError as error:
            raise InexpressibleError(f"a default that {error}") from None

    def _constant(self, constant: Const) -> Iterator[str]:
        name = constant.name[-1] if self._exact else _constant_name(constant.name[-1])
        if not CONSTANT_NAME.fullmatch(name):
            shown = constant.name[-1]
            raise PlacedError(constant.span, f"the constant {shown}", shown)
        self._take(name, constant, constant.name[-1])
        try:
            form = self._form(constant.type)
            if form.bound is not None or not form.has_default:
                raise InexpressibleError(f"constants of the type {constant.type}")
            value = self._literal(constant.value, form)
        except InexpressibleError as error:
            raise PlacedError(constant.span, str(error), constant.name[-1]) from None
        above, beside = _comments(constant)
        yield from above
        yield f"{form.text} {name}={value}{beside}"

    def _enumerators(self, member: Member) -> Iterator[str]:
        plain = self._model.unalias(member.type)
        declaration = self._model.declared(getattr(plain, "element", plain))
        if isinstance(declaration, Enum):
            for each in declaration.members:
                name = _constant_name(
                    f"{field_name(member.name)}_{field_name(each.name)}"
                )
                self._take(name, member, each.name)
                yield f"uint32 {name}={each.value}"


def _constant_name(name: str) -> str:
    return field_name(name).upper()


def _comments(declared: Member | Const) -> tuple[list[str], str]:
    """Return the comment above a line, and the one behind it, which has the unit."""
    lines = [line for line in declared.doc.splitlines() if line.strip()]
    unit = annotated_unit(declared)
    beside = ""
    if unit is not None and unit != unit_in(declared.doc):
        beside = f"[{unit}]"
    if len(lines) == 1:
        beside = f"{' '.join(lines[0].split())} {beside}".strip()
        lines = []
    above = [*_comment_lines("\n".join(lines))]
    return above, f"  # {comment(beside)}" if beside else ""


def _comment_lines(text: str) -> Iterator[str]:
    yield from (f"# {comment(line)}".rstrip() for line in text.splitlines())
