"""Compiles the codecs of a type from its descriptor at first use.

The source text of each function is entered in `linecache`, so that debuggers and tracebacks show
it. Compiled functions are cached in the descriptor.
"""

from __future__ import annotations

import linecache
from collections.abc import Callable
from threading import RLock
from typing import Any

from rtgen.runtime.marshalling.formats import CLASSIC, Format, NotCompiledError
from rtgen.runtime.marshalling.functions import FUNCTIONS
from rtgen.runtime.marshalling.references import References

_LOCK = RLock()


def compiled(
    kind: str, descriptor: Any, format_: Format = CLASSIC
) -> Callable[..., Any]:
    """The compiled function of a kind (a key of `FUNCTIONS`) for a type in a format.

    Raises NotCompiledError for a type that has none.
    """
    key = (kind, format_)
    if key not in descriptor.codecs:
        with _LOCK:
            try:
                _compile(kind, descriptor, format_)
            except NotCompiledError:
                descriptor.codecs[key] = None
    function: Callable[..., Any] | None = descriptor.codecs[key]
    if function is None:
        raise NotCompiledError(descriptor.name)
    return function


def _compile(kind: str, descriptor: Any, format_: Format) -> None:
    """Compiles a function and its callees; none is cached before all are complete."""
    made: dict[tuple[str, int], tuple[Any, Callable[..., Any]]] = {}
    calls: list[tuple[dict[str, Any], str, str, Any]] = []
    waiting = [(kind, descriptor)]
    while waiting:
        kind, described = waiting.pop()
        if (kind, id(described)) in made or (kind, format_) in described.codecs:
            continue
        function, references = _function(kind, described, format_)
        made[kind, id(described)] = described, function
        for name, needed, of in references.needed.values():
            calls.append((function.__globals__, name, needed, of))
            waiting.append((needed, of))
    for namespace, name, needed, of in calls:
        known = of.codecs.get((needed, format_))
        namespace[name] = made[needed, id(of)][1] if known is None else known
    for (kind, _), (described, function) in made.items():
        described.codecs.setdefault((kind, format_), function)


def _function(
    kind: str, descriptor: Any, format_: Format
) -> tuple[Callable[..., Any], References]:
    references = References(format_)
    head, lines = FUNCTIONS[kind](descriptor, references)
    text = "".join(f"{line}\n" for line in [head, *(f"    {x}" for x in lines)])
    form = f"XCDR{format_.version}" if format_.version else "CDR"
    file = _unused(f"<{form} {kind} of {descriptor.name}>")
    linecache.cache[file] = (len(text), None, text.splitlines(keepends=True), file)
    namespace = references.namespace.values
    namespace["__name__"] = __name__
    exec(compile(text, file, "exec"), namespace)
    function: Callable[..., Any] = namespace[head.split("(")[0].removeprefix("def ")]  # type: ignore[assignment]
    return function, references


def _unused(file: str) -> str:
    number = 1
    name = file
    while name in linecache.cache:
        number += 1
        name = f"{file[:-1]} {number}>"
    return name
