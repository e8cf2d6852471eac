"""Global names of a compiled function: classes, functions, other compiled functions."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

from rtgen.runtime.marshalling.descriptors import ANY
from rtgen.runtime.marshalling.layouts.formats import Format
from rtgen.runtime.marshalling.layouts.trees import can_evolve
from rtgen.runtime.marshalling.source.text import Namespace


class References:
    """Binds names in the globals of a function.

    `needed` are the compiled functions among them (name, kind, descriptor), of the same `format`.
    `decoded_again` is called by a decoder of XCDR with octets that it rejects. `evolving`: values
    of other versions of appendable types are read.
    """

    def __init__(self, format_: Format, decoded_again: Callable[..., Any]) -> None:
        self.format = format_
        self.decoded_again = decoded_again
        self.evolving = False
        self.namespace = Namespace()
        self.needed: dict[tuple[str, int], tuple[str, str, Any]] = {}

    def function(self, function: Callable[..., object]) -> str:
        """Return a function of the runtime."""
        return self.namespace.bind(function.__name__, function)

    def made(self, descriptor: Any) -> str:
        """Return the class of the type's values."""
        class_ = descriptor.class_
        return self.namespace.bind(class_.__name__, class_)

    def descriptor(self, descriptor: Any) -> str:
        """Return the descriptor itself."""
        return self.namespace.bind("descriptor", descriptor)

    def compiled(self, kind: str, descriptor: Any) -> str:
        """Return the function of a kind that is compiled for the type."""
        key = (kind, id(descriptor))
        if key not in self.needed:
            class_name = descriptor.name.rpartition("::")[2]
            name = self.namespace.free(f"{kind}_{class_name}")
            self.needed[key] = (name, kind, descriptor)
        return self.needed[key][0]

    def writer(self, descriptor: Any) -> str:
        """Return the function that appends a value of the type to a body."""
        return self.compiled("write", descriptor)

    def reader(self, descriptor: Any) -> str:
        """Return the function that reads a value of the type at an offset."""
        evolving = self.evolving and can_evolve(descriptor)
        return self.compiled("evolve" if evolving else "read", descriptor)

    def dynamic_writer(self, descriptor: Any) -> str:
        """Return the function that appends a value whose type is known only at run time."""
        from rtgen.runtime.marshalling.dynamic.anys import write_any
        from rtgen.runtime.marshalling.dynamic.writer import write_dynamic

        return self.function(write_any if descriptor == ANY else write_dynamic)

    def dynamic_reader(self, descriptor: Any) -> str:
        """Return the function that reads a value whose type is known only at run time."""
        from rtgen.runtime.marshalling.dynamic.anys import read_any
        from rtgen.runtime.marshalling.dynamic.reader import read_dynamic

        return self.function(read_any if descriptor == ANY else read_dynamic)
