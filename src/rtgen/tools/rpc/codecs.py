"""Generates codecs of signatures in memory, and describes their functions."""

from __future__ import annotations

import sys
from collections.abc import Callable, Iterator, Mapping, Sequence
from itertools import count, islice, product
from types import ModuleType
from typing import TypeVar, cast

from rtgen.compiler.backends.tecs.codec import codec_text
from rtgen.compiler.backends.tecs.expressions import expression_text
from rtgen.compiler.backends.tecs.types_module import types_text
from rtgen.compiler.layouts.tdr import FunctionLayout, Item, SignatureLayout
from rtgen.compiler.layouts.tdr_messages import layout_of
from rtgen.compiler.model.c_types import Expression
from rtgen.compiler.model.tecs import Signature, TecsUnit
from rtgen.compiler.typemap.tecs.python import codec_class, codec_module, zero
from rtgen.runtime.opaque_rpc import (
    E_BOVR,
    REQUEST_LIMIT,
    ArgumentError,
    Channel,
    ChannelError,
    Codec,
    More,
    ProtocolError,
    ReplyOrder,
    RpcError,
    Tdr,
)
from rtgen.runtime.opaque_rpc import codecs as runtime_codecs
from rtgen.runtime.opaque_rpc.codecs import Messages
from rtgen.runtime.opaque_rpc.tdr import SOP_REQUEST
from rtgen.tools.rpc.values import (
    Json,
    JsonError,
    arguments_from_json,
    arguments_to_json,
    item_from_json,
    item_to_json,
    outs_from_json,
    to_json,
)

_PACKAGES = count()
_MAX_GUESSES = 100_000
R = TypeVar("R")


class Service:
    """A signature with its codec for one TDR and reply order. Raises TransferError."""

    def __init__(
        self,
        unit: TecsUnit,
        signature: Signature,
        tdr: Tdr,
        reply: ReplyOrder = "tecsgen",
        limit: int = REQUEST_LIMIT,
    ) -> None:
        self.signature = signature
        self.layout: SignatureLayout = layout_of(unit, signature)
        self.types, class_ = _loaded(unit, signature, reply)
        self.codec: Codec = class_(tdr, limit=limit)
        messages = {f.name: f for f in self.codec.functions.values()}
        self.functions = {
            name: Function(layout, self.codec, messages[name], self.types)
            for layout in self.layout.functions
            for name in [layout.function.name]
        }


def _loaded(
    unit: TecsUnit, signature: Signature, reply: ReplyOrder
) -> tuple[ModuleType, Callable[..., Codec]]:
    package = f"_rtgen_rpc_{next(_PACKAGES)}"
    _module(package, "").__path__ = []
    types = _module(
        f"{package}._types", types_text(unit, [layout_of(unit, signature)], "")
    )
    name = f"{package}.{codec_module(signature)}"
    codec = _module(name, codec_text(unit, signature, "", reply))
    return types, cast(Callable[..., Codec], getattr(codec, codec_class(signature)))


def _module(name: str, text: str) -> ModuleType:
    module = ModuleType(name)
    module.__package__ = name.rpartition(".")[0] or name
    sys.modules[name] = module
    exec(compile(text, f"<{name}>", "exec"), module.__dict__)
    return module


class Function:
    """A function of a service."""

    def __init__(
        self,
        layout: FunctionLayout,
        codec: Codec,
        messages: Messages[..., object],
        types: ModuleType,
    ) -> None:
        self.layout = layout
        self.name = layout.function.name
        self.oneway = layout.function.oneway
        self._codec = codec
        self._messages = messages
        self._types = types

    @property
    def first(self) -> int:
        """Number of octets of a reply to read first; 0 for a oneway function."""
        return self._messages.first

    def encode_request(self, arguments: Sequence[object]) -> bytes:
        """Encode a request. Raises ArgumentError."""
        return self._messages.encode_request(*arguments)

    def read_request(self, more: More) -> tuple[object, ...]:
        """Read the arguments that follow SOP and function id. Raises RpcError."""
        return self._messages.read_request(more)

    def decode_request(self, data: bytes) -> tuple[object, ...]:
        """Decode the arguments of a complete request. Raises RpcError."""
        reader = Reader(data)
        head = reader.more(4)
        if head != self._codec.request_head(self.layout.function.id):
            sop = self._codec.tdr.int16(SOP_REQUEST)
            what = "another function" if head[:2] == sop else "no request"
            raise ChannelError(E_BOVR, f"{self.name}: this is {what}")
        arguments = self.read_request(reader.more)
        reader.finish()
        return arguments

    def encode_reply(
        self, kept: Sequence[object], returned: object, outs: Sequence[object]
    ) -> bytes:
        """Encode a reply. Raises ArgumentError."""
        results = [] if self.layout.is_void else [returned]
        return self._messages.encode_reply(*kept, *results, *outs)

    def read_reply(
        self, first: bytes, more: More, kept: Sequence[object]
    ) -> tuple[object, tuple[object, ...] | None]:
        """Read return value and outs; None for omitted outs. Raises RpcError."""
        return self._messages.read_reply(first, more, *kept)

    def decode_reply(
        self, data: bytes, kept: Sequence[object]
    ) -> tuple[object, tuple[object, ...] | None]:
        """Decode a complete reply. Raises RpcError."""
        reader = Reader(data)
        values = self.read_reply(reader.more(self.first), reader.more, kept)
        reader.finish()
        return values

    def call(
        self, channel: Channel, arguments: tuple[object, ...]
    ) -> tuple[object, tuple[object, ...] | None]:
        """Call the function; return its value and outs. Raises RpcError and ArgumentError."""
        head = channel.begin(self.encode_request(arguments), self.first)
        if self.oneway:
            channel.end()
            return 0, ()
        try:
            result = self.read_reply(head, channel.more, self.kept(arguments))
        except BaseException:
            channel.reset()
            raise
        channel.end()
        return result

    def kept(self, arguments: Sequence[object]) -> tuple[object, ...]:
        """Return the arguments that the layout of the reply depends on."""
        values = dict(
            zip((i.name for i in self.layout.arguments), arguments, strict=True)
        )
        return tuple(values[item.name] for item in self.layout.kept)

    def evaluated(self, expression: Expression, known: Mapping[str, object]) -> int:
        """Return the value of a size, given the parameters that it refers to."""
        items = {item.name: item for item in self.layout.items}
        text = expression_text(
            expression, lambda name: (f"known[{name!r}]", items[name])
        )
        names = {**vars(runtime_codecs), "known": known, "self": self._codec}
        return int(eval(text, names))

    def zeros(self) -> tuple[object, tuple[object, ...]]:
        """Return a zero result and zero outs."""
        outs = tuple(self._zero(item) for item in self.layout.outs)
        return self._zero(self.layout.returned), outs

    def _zero(self, item: Item) -> object:
        return eval(zero(item.node), dict(self._types.__dict__))

    def arguments_from_json(self, value: Json) -> tuple[object, ...]:
        """Convert a JSON object to arguments. Raises JsonError."""
        return arguments_from_json(self.layout.arguments, value, self._types)

    def arguments_to_json(self, arguments: Sequence[object]) -> Json:
        """Convert arguments to a JSON object."""
        return arguments_to_json(self.layout.arguments, arguments)

    def result_from_json(self, value: Json) -> tuple[object, tuple[object, ...]]:
        """Convert JSON to result and outs; outs that are null become zeros. Raises JsonError."""
        if not isinstance(value, dict) or not {"return", "outs"}.issuperset(value):
            raise JsonError('a reply is {"return": ..., "outs": {...}}')
        returned: object = None
        if not self.layout.is_void:
            if value.get("return") is None:
                raise JsonError("'return' is missing")
            returned = item_from_json(
                self.layout.returned, value["return"], self._types
            )
        outs = value.get("outs", {})
        if outs is None and self.layout.leaves_out:
            return returned, self.zeros()[1]
        return returned, outs_from_json(self.layout.outs, outs, self._types)

    def result_to_json(
        self, returned: object, outs: Sequence[object] | None
    ) -> dict[str, Json]:
        """Convert a reply to a JSON object."""
        values: Json = None
        if outs is not None:
            pairs = zip(self.layout.outs, outs, strict=True)
            values = {item.name: item_to_json(item, value) for item, value in pairs}
        result = to_json(self.layout.returned.node, returned)
        return {"return": result, "outs": values}

    def guessed(self, largest: int, attempt: Callable[[tuple[object, ...]], R]) -> R:
        """Return the first result of an attempt with kept arguments of an unknown request.

        `largest` is the largest size. Raises RpcError or ArgumentError, the first of all attempts.
        """
        failure: Exception | None = None
        for kept in islice(self.guesses(largest), _MAX_GUESSES):
            try:
                return attempt(kept)
            except (RpcError, ArgumentError) as error:
                failure = failure or error
        assert failure is not None
        raise failure

    def guesses(self, largest: int) -> Iterator[tuple[object, ...]]:
        """Yield candidates for the kept arguments of an unknown request; large sizes first."""
        sizes: list[object] = [(1 << 31) - 1, *range(largest, -1, -1)]
        choices: list[list[object]] = []
        for item in self.layout.kept:
            if item.asked:
                choices.append([True, False])
            elif item.nullable:
                choices.append([0, None])
            else:
                choices.append(sizes)
        return product(*choices)


class Reader:
    """Reads the octets of a complete message."""

    def __init__(self, data: bytes) -> None:
        self._data = data
        self._at = 0

    def more(self, n: int) -> bytes:
        """Return the next n octets. Raises ChannelError if fewer are left."""
        octets = self._data[self._at : self._at + n]
        if len(octets) != n:
            raise ChannelError(E_BOVR, f"{n - len(octets)} bytes are missing")
        self._at += n
        return octets

    def finish(self) -> None:
        """Raise ProtocolError if octets are left."""
        remaining = len(self._data) - self._at
        if remaining:
            raise ProtocolError(E_BOVR, f"{remaining} bytes are left over")
