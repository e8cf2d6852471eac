"""The configuration of a component as parameters of a node (rcl_interfaces).

Parameters have the values of the active configuration set, and are set in it;
`configuration.active_config` is its id.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Sequence
from decimal import Decimal
from enum import IntEnum
from typing import Any, Final, TypeVar

from rtgen.facts import parameter_texts
from rtgen.facts.primitives import FLOAT_LIMITS, INTEGER_RANGES
from rtgen.runtime.errors import ConfigurationError
from rtgen.runtime.ros2.life_cycle import Members
from rtgen.runtime.rtc.configuration import ACTIVE_SET, ConfigurationSets
from rtgen.runtime.services.servants import ServiceError

SERVICES: Final = {
    "list_parameters": "ListParameters",
    "get_parameters": "GetParameters",
    "get_parameter_types": "GetParameterTypes",
    "describe_parameters": "DescribeParameters",
    "set_parameters": "SetParameters",
    "set_parameters_atomically": "SetParametersAtomically",
}
"""Types of rcl_interfaces/srv by names of services, which are methods of `Parameters`."""


class Kind(IntEnum):
    """Constants of rcl_interfaces/msg/ParameterType."""

    NOT_SET = 0
    BOOL = 1
    INTEGER = 2
    DOUBLE = 3
    STRING = 4
    BYTE_ARRAY = 5
    BOOL_ARRAY = 6
    INTEGER_ARRAY = 7
    DOUBLE_ARRAY = 8
    STRING_ARRAY = 9


_ARRAY: Final = Kind.BOOL_ARRAY - Kind.BOOL
ACCEPTED: Final = {
    Kind.DOUBLE: (Kind.INTEGER,),
    Kind.DOUBLE_ARRAY: (Kind.INTEGER_ARRAY,),
    Kind.BYTE_ARRAY: (Kind.INTEGER_ARRAY,),
}
"""Kinds of values accepted for another kind of parameter: tools write `2` for 2.0."""
_MIN_INTEGER, _MAX_INTEGER = INTEGER_RANGES["long long"]
_INFINITE: Final = float("inf")


_MAX_NAMES: Final = 10_000
"""Maximum number of names, prefixes or parameters in a request."""

T = TypeVar("T")


class _RefusedError(Exception):
    """A parameter that cannot be set; the message says why."""


class Parameters:
    """Implements the parameter services of one component."""

    def __init__(self, sets: ConfigurationSets) -> None:
        self._sets = sets
        self._profiles = {profile.name: profile for profile in sets.parameters}

    def list_parameters(self, request: Any) -> Members:
        """Return the names at or below the prefixes, at most `depth` words deep; 0: any depth."""
        bounded(request.prefixes)
        names = [n for n in (*self._profiles, ACTIVE_SET) if is_listed(n, request)]
        above = (name.rpartition(".")[0] for name in names)
        prefixes = list(dict.fromkeys(filter(None, above)))
        return {"result": {"names": names, "prefixes": prefixes}}

    def get_parameters(self, request: Any) -> Members:
        """Return the values; NOT_SET for unknown names."""
        return {"values": [self.value(name) for name in bounded(request.names)]}

    def get_parameter_types(self, request: Any) -> Members:
        """Return the types; NOT_SET for unknown names."""
        names = bounded(request.names)
        return {"types": bytes(self.value(name)["type"] for name in names)}

    def describe_parameters(self, request: Any) -> Members:
        """Return the descriptors; for unknown names those of a parameter that is not set."""
        return {"descriptors": [self._descriptor(n) for n in bounded(request.names)]}

    def set_parameters(self, request: Any) -> Members:
        """Set parameters one by one."""
        return {"results": [self._set([each]) for each in bounded(request.parameters)]}

    def set_parameters_atomically(self, request: Any) -> Members:
        """Set all parameters between the same two cycles, or none."""
        return {"result": self._set(bounded(request.parameters))}

    def value(self, name: str, text: str | None = None) -> Members:
        """Return the ParameterValue of a parameter, or of a text for it."""
        if name == ACTIVE_SET:
            return {"type": Kind.STRING, "string_value": self._sets.active}
        if name not in self._profiles:
            return {"type": Kind.NOT_SET}
        if text is None:
            text = self._sets.texts(self._sets.active)[name]
        found = self._sets.value(name, text)
        kind = _kind(self._profiles[name].type, found)
        return {"type": kind, value_member(kind): _plain(kind, found)}

    def _descriptor(self, name: str) -> Members:
        kind = self.value(name)["type"]
        members: Members = {"name": name, "type": kind}
        profile = self._profiles.get(name)
        if profile is None:
            return members
        unit = f"[{profile.unit}]" if profile.unit else ""
        words = filter(None, (profile.description, unit))
        return members | {
            "description": " ".join(words),
            "additional_constraints": profile.constraint,
            **range_of(kind, profile.minimum, profile.maximum),
        }

    def _set(self, parameters: Iterable[Any]) -> Members:
        try:
            texts = dict(self._texts(parameters))
            target = texts.pop(ACTIVE_SET, None)
            if target is not None:
                self._sets.texts(target)  # raises UnknownConfigurationSetError
            self._sets.set_all(texts, self._sets.active if target is None else target)
            if target is not None:
                self._sets.activate(target)
        except (_RefusedError, ConfigurationError) as error:
            return {"successful": False, "reason": str(error)}
        return {"successful": True}

    def _texts(self, parameters: Iterable[Any]) -> Iterator[tuple[str, str]]:
        for parameter in parameters:
            name, value = parameter.name, parameter.value
            expected = self.value(name)["type"]
            if expected == Kind.NOT_SET:
                known = ", ".join((*self._profiles, ACTIVE_SET))
                raise _RefusedError(f"there is no parameter {name!r}; known: {known}")
            if value.type != expected and value.type not in ACCEPTED.get(expected, ()):
                given = kind_name(value.type)
                raise _RefusedError(
                    f"parameter {name!r} is of type {kind_name(expected)}, not {given}"
                )
            try:
                found = getattr(value, value_member(Kind(value.type)))
                yield name, parameter_texts.text_of(found)
            except ValueError as error:
                raise _RefusedError(f"parameter {name!r}: {error}") from None


def bounded(items: Sequence[T]) -> Sequence[T]:
    """Return the items of a request. Raises ServiceError for too many."""
    if len(items) > _MAX_NAMES:
        raise ServiceError(f"{len(items)} items; a request may have {_MAX_NAMES}")
    return items


def is_listed(name: str, request: Any) -> bool:
    """Return whether a parameter is at or below the prefixes of a request."""
    depth: int = request.depth

    def is_within(rest: str) -> bool:
        return depth == 0 or rest.count(".") < depth

    if not request.prefixes:
        return is_within(name)
    return any(
        name == prefix
        or (name.startswith(f"{prefix}.") and is_within(name[len(prefix) + 1 :]))
        for prefix in request.prefixes
    )


def kind_name(kind: int) -> str:
    """Return the word for a kind in messages."""
    names = {each.value: each.name.lower() for each in Kind}
    return names.get(kind, f"unknown ({kind})")


def value_member(kind: Kind) -> str:
    """Return the member of rcl_interfaces/msg/ParameterValue for values of a kind."""
    return f"{kind.name.lower()}_value"


def _kind(type_: str, value: Any) -> Kind:
    """Return the kind of a parameter of an IDL type, which may be the name of an alias."""
    match value:
        case bytes():
            return Kind.BYTE_ARRAY
        case list():
            element = (
                type_.removeprefix("sequence<").partition(",")[0].partition("[")[0]
            )
            element = element.removesuffix(">")
            kinds = (_kind(element, each) for each in value)
            return Kind(max(kinds, default=_scalar(element)) + _ARRAY)
        case IntEnum() | str() | Decimal():
            return Kind.STRING
        case bool():
            return Kind.BOOL
        case int() if type_ not in FLOAT_LIMITS:
            return (
                Kind.INTEGER if _MIN_INTEGER <= value <= _MAX_INTEGER else Kind.STRING
            )
    return Kind.DOUBLE


def _scalar(type_: str) -> Kind:
    """Return the kind of the elements of an empty list."""
    if type_ == "boolean":
        return Kind.BOOL
    if type_ in INTEGER_RANGES:
        return Kind.INTEGER
    return Kind.STRING if "string" in type_ or "char" in type_ else Kind.DOUBLE


def _plain(kind: Kind, value: Any) -> Any:
    """Return a value in the form of a ParameterValue."""
    if isinstance(value, list):
        return [_plain(Kind(kind - _ARRAY), each) for each in value]
    if isinstance(value, IntEnum):
        return value.name
    return str(value) if kind is Kind.STRING else value


def range_of(kind: Kind, low: float | None, high: float | None) -> Members:
    """Return the range of a descriptor; none for a parameter without limits."""
    if low is None and high is None:
        return {}
    if kind in (Kind.INTEGER, Kind.INTEGER_ARRAY):
        limits = (
            _MIN_INTEGER if low is None else max(int(low), _MIN_INTEGER),
            _MAX_INTEGER if high is None else min(int(high), _MAX_INTEGER),
        )
        return {"integer_range": [_range(*limits)]}
    limits_of_reals = (
        -_INFINITE if low is None else float(low),
        _INFINITE if high is None else float(high),
    )
    return {"floating_point_range": [_range(*limits_of_reals)]}


def _range(low: float, high: float) -> Members:
    return {"from_value": low, "to_value": high}
