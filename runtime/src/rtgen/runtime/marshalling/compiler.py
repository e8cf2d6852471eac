"""Compiles the codecs of a type from its descriptor at first use.

A type that `rtgen-speed` covers has codecs in C, if that is installed (`tables`).
The source text of each function is entered in `linecache`, so that debuggers and tracebacks show
it. Compiled functions are cached in the descriptor.
"""

from __future__ import annotations

from collections.abc import Callable
from functools import partial
from threading import RLock
from typing import Any

from rtgen.runtime.marshalling.descriptors import StructDescriptor
from rtgen.runtime.marshalling.errors import FAILURES, Buffer, CdrError, Fault
from rtgen.runtime.marshalling.layouts.formats import CLASSIC, Format, UnsupportedError
from rtgen.runtime.marshalling.layouts.trees import can_evolve, unsupported
from rtgen.runtime.marshalling.source.functions import FUNCTIONS
from rtgen.runtime.marshalling.source.references import References
from rtgen.runtime.marshalling.source.text import entered
from rtgen.runtime.marshalling.tables import codec

_LOCK = RLock()


def compiled(
    kind: str, descriptor: Any, format_: Format = CLASSIC
) -> Callable[..., Any]:
    """Return the codec of a kind (a key of `FUNCTIONS`) for a type in a format.

    For a type that XCDR cannot represent, it is a function that raises CdrError. Raises
    UnsupportedError for one that CDR cannot represent.
    """
    key = (kind, format_)
    if key not in descriptor.codecs:
        in_python = partial(compiled_in_python, kind, descriptor, format_)
        with _LOCK:
            chosen = codec(kind, descriptor, format_, in_python)
            descriptor.codecs[key] = in_python() if chosen is None else chosen
    function: Callable[..., Any] = descriptor.codecs[key]
    return function


def compiled_in_python(
    kind: str, descriptor: Any, format_: Format = CLASSIC
) -> Callable[..., Any]:
    """Return the function in Python, whose callees are functions in Python, too."""
    key = ((compiled_in_python, kind), format_)
    if key not in descriptor.codecs:
        with _LOCK:
            try:
                _compile(kind, descriptor, format_)
            except UnsupportedError:
                if not format_.version:
                    raise
                descriptor.codecs[key] = _refusing(descriptor, format_)
    function: Callable[..., Any] = descriptor.codecs[key]
    return function


def decoded_again(
    type_: Any, data: Buffer, format_: Format, little_endian: bool, failure: Exception
) -> Any:
    """Decode a body that the compiled codec rejected: another version of the type.

    Raises CdrError with the place of the error.
    """
    from rtgen.runtime.marshalling.dynamic.fault_search import fault_in_body

    descriptor = type_._descriptor_
    name = str(descriptor.name).rpartition("::")[2]
    try:
        octets = bytes(memoryview(data))
    except TypeError:
        message = f"octets are needed, not {type(data).__name__}"
        raise CdrError(name, message) from failure
    if _evolves(descriptor, format_):
        decode = compiled_in_python("from_evolved", descriptor, format_)
        try:
            return decode(type_, octets, little_endian)
        except FAILURES as again:
            failure = again
    if isinstance(failure, RecursionError):
        raise CdrError(name, "the value is nested too deeply") from failure
    fault = fault_in_body(descriptor, octets, format_, little_endian)
    if fault is None:
        fault = Fault(str(failure))
    raise fault.error(name) from failure


def _evolves(descriptor: Any, format_: Format) -> bool:
    """Return whether octets of another version of the type can be read."""
    if format_.version == 1:
        extensibility = getattr(descriptor, "extensibility", "")
        return isinstance(descriptor, StructDescriptor) and (
            extensibility == "appendable"
        )
    key = ("evolves", format_)
    if key not in descriptor.codecs:
        descriptor.codecs[key] = can_evolve(descriptor)
    evolves: bool = descriptor.codecs[key]
    return evolves


def _refusing(descriptor: Any, format_: Format) -> Callable[..., Any]:
    """Return the codec of a type that the format cannot represent, which raises CdrError."""
    name = str(descriptor.name).rpartition("::")[2]
    path, message = unsupported(descriptor, format_)

    def refuse(*_: object) -> None:
        raise CdrError(name + path, message)

    return refuse


def _compile(kind: str, descriptor: Any, format_: Format) -> None:
    """Compile a function and its callees; none is cached before all are complete."""
    functions: dict[tuple[str, int], tuple[Any, Callable[..., Any]]] = {}
    calls: list[tuple[dict[str, Any], str, str, Any]] = []
    waiting = [(kind, descriptor)]
    while waiting:
        kind, described = waiting.pop()
        key = ((compiled_in_python, kind), format_)
        if (kind, id(described)) in functions or key in described.codecs:
            continue
        function, references = _function(kind, described, format_)
        functions[kind, id(described)] = described, function
        for name, needed, of in references.needed.values():
            calls.append((function.__globals__, name, needed, of))
            waiting.append((needed, of))
    for namespace, name, needed, of in calls:
        function = of.codecs.get(((compiled_in_python, needed), format_))
        namespace[name] = functions[needed, id(of)][1] if function is None else function
    for (kind, _), (described, function) in functions.items():
        described.codecs.setdefault(((compiled_in_python, kind), format_), function)


def _function(
    kind: str, descriptor: Any, format_: Format
) -> tuple[Callable[..., Any], References]:
    references = References(format_, decoded_again)
    head, lines = FUNCTIONS[kind](descriptor, references)
    text = "".join(f"{line}\n" for line in [head, *(f"    {x}" for x in lines)])
    file = entered(text, f"<{format_} {kind} of {descriptor.name}>")
    namespace = references.namespace.values
    namespace["__name__"] = __name__
    functions: dict[str, Callable[..., Any]] = (
        {}
    )  # a class may have the function's name
    exec(compile(text, file, "exec"), namespace, functions)
    [function] = functions.values()
    return function, references
