"""Conversions between the forms of numbers (`@numeric`), for generated adapters."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any, TypeVar

from rtgen.runtime.marshalling.errors import FAILURES, CdrError

if TYPE_CHECKING:
    import numpy
    from numpy.typing import NDArray

    _N = TypeVar("_N", bound=numpy.generic)

_S = TypeVar("_S")


def to_numpy(
    numbers: Any, item: type[_N], path: str, factor: float = 1.0, offset: float = 0.0
) -> NDArray[_N]:
    """Return `factor * numbers + offset` as a numpy array.

    `path` names the member. Raises CdrError for numbers that the item cannot represent.
    """
    import numpy

    is_real = issubclass(item, numpy.floating)
    try:
        exact = numpy.asarray(numbers, numpy.float64 if is_real else item)
    except FAILURES as error:
        raise CdrError(path, str(error)) from None
    if not is_real:
        return exact
    if factor != 1 or offset:
        exact = factor * exact + offset
    with numpy.errstate(over="ignore"):
        array = exact.astype(item, copy=False)
    beyond = numpy.argwhere(numpy.isinf(array) & numpy.isfinite(exact))
    if len(beyond):
        place = tuple(beyond[0])
        indices = "".join(f"[{index}]" for index in place)
        raise CdrError(path + indices, f"{exact[place]} is out of the range of float")
    return array


def to_list(numbers: Any) -> Any:
    """Return the items of a numpy array as a list, or as lists of lists."""
    import numpy

    return numpy.asarray(numbers).tolist()


def to_records(structs: list[_S], class_: type[_S], path: str) -> NDArray[numpy.void]:
    """Return structs of numbers as a structured array. Raises CdrError."""
    import numpy

    from rtgen.runtime.marshalling import structured

    descriptor: Any = class_
    try:
        with numpy.errstate(over="raise"):
            return structured.records_of(structs, descriptor._descriptor_)
    except FAILURES as error:
        raise CdrError(path, str(error)) from None


def to_structs(records: NDArray[numpy.void], class_: type[_S]) -> list[_S]:
    """Return the elements of a structured array as structs."""
    from rtgen.runtime.marshalling import structured

    descriptor: Any = class_
    return structured.values_of(records, descriptor._descriptor_)
