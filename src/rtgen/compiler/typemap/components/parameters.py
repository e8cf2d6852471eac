"""Validates configuration parameters and converts them from and to text."""

from __future__ import annotations

from decimal import Decimal
from math import inf, isfinite

from rtgen.compiler.model import (
    ConfigurationParameter,
    ConstantValue,
    Enum,
    EnumeratorName,
    Model,
    NamedType,
    Primitive,
    PrimitiveType,
    SequenceType,
    StringType,
    Type,
)
from rtgen.compiler.typemap.components.parameter_types import WORDS
from rtgen.facts import parameter_texts
from rtgen.facts.constraints import (
    Constraint,
    ConstraintError,
    KeyConstraints,
    allows,
    check_literals,
    enumeration,
    interval,
    literals,
    parse,
)
from rtgen.facts.primitives import FLOAT_LIMITS, INTEGER_RANGES


class ValueMismatchError(ValueError):
    """An invalid value for the type; the text gives the reason."""


class Parameters:
    """The parameters of a model's components, with typedefs and enums resolved."""

    def __init__(self, model: Model) -> None:
        self._model = model

    def is_supported(self, type_: Type) -> bool:
        """Return whether a parameter can have the type; see the rule RTC0302."""
        item = self.item_type(type_)
        match item:
            case PrimitiveType(kind):
                return kind in WORDS
            case StringType():
                return True
            case _:
                return item == self._model.unalias(type_) and bool(
                    self.enumerators(item)
                )

    def profile_type(self, type_: Type) -> str:
        """Return `rtc:type` in an RtcProfile: a C++ type, as written by RTCBuilder."""
        type_ = self._model.unalias(type_)
        match type_:
            case SequenceType(element):
                word = self.profile_type(element)
                return f"std::vector<{'std::string' if word == 'string' else word}>"
            case PrimitiveType(kind):
                return WORDS[kind]
            case _:
                return "string"

    def canonical_type(self, type_: Type) -> str:
        """Return IDL's spelling with typedefs resolved; an enum keeps its scoped name."""
        type_ = self._model.unalias(type_)
        if isinstance(type_, SequenceType):
            bound = "" if type_.bound is None else f",{type_.bound}"
            return f"sequence<{self.canonical_type(type_.element)}{bound}>"
        return str(type_)

    def default_text(self, parameter: ConfigurationParameter) -> str:
        """Return the default as text, falling back to the zero value of the type."""
        if parameter.default is not None:
            return value_text(parameter.default)
        type_ = self._model.unalias(parameter.type)
        match type_:
            case PrimitiveType(kind):
                return "0.0" if kind in FLOAT_LIMITS else "0"
            case NamedType(name):
                enum = self._model.find(name)
                assert isinstance(enum, Enum), "checked before"
                return enum.initial.name
            case _:
                return ""

    def enumerators(self, type_: Type) -> tuple[str, ...]:
        """Return the names of an enum's members; empty for other types."""
        enum = self._model.declared(type_)
        return tuple(m.name for m in enum.members) if isinstance(enum, Enum) else ()

    def default_items(self, parameter: ConfigurationParameter) -> list[str]:
        """Return the items of the default: one for a scalar, any number for a sequence."""
        text = self.default_text(parameter)
        if self.is_sequence(parameter.type):
            return parameter_texts.items(text)
        return [text]

    def constraint(self, parameter: ConfigurationParameter) -> Constraint | None:
        """Return the constraint as written, else that of the bounds or of the enum's members."""
        written = parse(parameter.constraint)
        if written is not None:
            self._check_literals(parameter.type, written)
            return written
        names = self.enumerators(self.item_type(parameter.type))
        return self.bounds(parameter) or (enumeration(names) if names else None)

    def bounds(self, parameter: ConfigurationParameter) -> Constraint | None:
        """Return the constraint of `@min` and `@max`; None without either."""
        ends = (parameter.minimum, parameter.maximum)
        lower, upper = (None if end is None else value_text(end) for end in ends)
        return interval(lower, upper)

    def is_default_allowed(
        self, parameter: ConfigurationParameter, limit: Constraint
    ) -> bool:
        """Return whether the default, of the right type, meets the constraint."""
        item = self.item_type(parameter.type)
        texts = self.default_items(parameter)
        return allows(limit, [self._value(item, text) for text in texts])

    def _value(self, type_: Type, text: str) -> bool | int | float | str:
        value = self.parse_item(type_, text)
        return text if isinstance(value, Decimal | EnumeratorName) else value

    def item_type(self, type_: Type) -> Type:
        """Return the element type of a sequence, or the type itself; typedefs are resolved."""
        type_ = self._model.unalias(type_)
        return (
            self._model.unalias(type_.element)
            if isinstance(type_, SequenceType)
            else type_
        )

    def is_sequence(self, type_: Type) -> bool:
        """Return whether a value is a sequence."""
        return isinstance(self._model.unalias(type_), SequenceType)

    def is_number(self, type_: Type) -> bool:
        """Return whether a value or its items are numbers (not booleans)."""
        item = self.item_type(type_)
        return isinstance(item, PrimitiveType) and (
            item.kind in INTEGER_RANGES or item.kind in FLOAT_LIMITS
        )

    def check_value(self, type_: Type, value: ConstantValue) -> None:
        """Raise ValueMismatchError if the value does not have the type."""
        type_ = self._model.unalias(type_)
        match type_:
            case PrimitiveType(Primitive.BOOLEAN):
                if not isinstance(value, bool):
                    raise ValueMismatchError(
                        f"{_shown(value)} is neither TRUE nor FALSE"
                    )
            case PrimitiveType(kind) if kind in INTEGER_RANGES:
                _check_integer(kind, value)
            case PrimitiveType(kind):
                _check_float(kind, value)
            case StringType(bound=bound):
                if not isinstance(value, str):
                    raise ValueMismatchError(f"{_shown(value)} is not a string")
                if bound is not None and len(value) > bound:
                    raise ValueMismatchError(
                        f"{_shown(value)} is longer than {bound} characters"
                    )
            case SequenceType(element, bound):
                self._check_items(element, bound, value)
            case _:
                names = self.enumerators(type_)
                if not isinstance(value, EnumeratorName) or value.name[-1] not in names:
                    raise ValueMismatchError(
                        f"{_shown(value)} is not one of {', '.join(names)}"
                    )

    def parse_item(self, type_: Type, text: str) -> ConstantValue:
        """Parse an item of a sequence. Raises ValueMismatchError."""
        type_ = self._model.unalias(type_)
        try:
            match type_:
                case PrimitiveType(Primitive.BOOLEAN):
                    return parameter_texts.boolean(text)
                case PrimitiveType(kind):
                    if kind in INTEGER_RANGES:
                        return parameter_texts.integer(text)
                    return parameter_texts.number(text)
                case StringType():
                    return text
                case NamedType(name):
                    return EnumeratorName((*name[:-1], text))
                case _:
                    raise ValueError(text)
        except ValueError:
            raise ValueMismatchError(f"{text!r} is not a value of {type_}") from None

    def _check_items(
        self, element: Type, bound: int | None, value: ConstantValue
    ) -> None:
        if not isinstance(value, str):
            raise ValueMismatchError(
                f"{_shown(value)} is not a text with commas between the items"
            )
        items = parameter_texts.items(value)
        if bound is not None and len(items) > bound:
            raise ValueMismatchError(f"{len(items)} items are more than {bound}")
        for item in items:
            self.check_value(element, self.parse_item(element, item))

    def _check_literals(self, type_: Type, constraint: Constraint) -> None:
        numeric = self.is_number(type_)
        check_literals(constraint, self.canonical_type(type_), numeric=numeric)
        if numeric or isinstance(constraint, KeyConstraints):
            return
        item_type = self.item_type(type_)
        for _, literal in literals(constraint):
            try:
                self.check_value(item_type, self.parse_item(item_type, literal))
            except ValueMismatchError as reason:
                raise ConstraintError(str(reason)) from None


def value_text(value: ConstantValue) -> str:
    """Return a value's text in profiles; booleans are 1 and 0, which every target accepts."""
    match value:
        case bool():
            return str(int(value))
        case EnumeratorName(name):
            return name[-1]
        case _:
            return str(value)


def _shown(value: ConstantValue) -> str:
    match value:
        case bool():
            return str(value).upper()
        case str():
            return f'"{value}"'
        case _:
            return value_text(value)


def _check_integer(kind: Primitive, value: ConstantValue) -> None:
    low, high = INTEGER_RANGES[kind]
    if isinstance(value, bool) or not isinstance(value, int):
        raise ValueMismatchError(f"{_shown(value)} is not a whole number")
    if not low <= value <= high:
        raise ValueMismatchError(f"{value} is not in {low} to {high}")


def _check_float(kind: Primitive, value: ConstantValue) -> None:
    if isinstance(value, bool) or not isinstance(value, int | float | Decimal):
        raise ValueMismatchError(f"{_shown(value)} is not a number")
    try:
        number = float(value)
    except OverflowError:
        number = inf
    if not isfinite(number):
        raise ValueMismatchError(f"{_shown(value)} is not finite as a {kind}")
    if abs(number) > FLOAT_LIMITS[kind]:
        raise ValueMismatchError(f"{value} is beyond the range of {kind}")
