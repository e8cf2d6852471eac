"""Compares recorded calls with the codecs of their signatures."""

from __future__ import annotations

import json
import struct
from collections.abc import Iterator, Mapping
from typing import Any, cast

from rtgen.compiler.diagnostics import has_errors
from rtgen.compiler.frontends.cdl import read_text
from rtgen.compiler.layouts.tdr import (
    Basic,
    Counted,
    FixedArray,
    Item,
    Node,
    Nothing,
    Record,
)
from rtgen.compiler.model.tecs import TecsUnit
from rtgen.facts.tdr import Scalar
from rtgen.runtime.opaque_rpc import ArgumentError, RpcError, make_tdr
from rtgen.runtime.opaque_rpc.tdr import SHARED_BEGIN, SHARED_END
from rtgen.tools.kit.exits import Refusal
from rtgen.tools.rpc.codecs import Function, Service
from rtgen.tools.rpc.signatures import Wire, service_of
from rtgen.tools.rpc.values import Json, JsonError

_ORDERS = {"tNBOTDR": "network", "tTDR": "little"}


class Replay:
    """The services of a file of recorded calls, cached."""

    def __init__(self, recorded: Mapping[str, Any], wire: Wire) -> None:
        self._recorded = recorded
        self._wire = wire
        self._units: dict[str, TecsUnit] = {}
        self._services: dict[tuple[str, str], Service] = {}

    def differences(self, case: Mapping[str, Any]) -> Iterator[str]:
        """Yield the differences to the record."""
        try:
            service = self._service(case["signature"], case["tdr"])
        except Refusal as error:
            yield str(error)
            return
        function = service.functions.get(case["function"])
        if function is None:
            yield f"no function {case['function']!r}"
            return
        try:
            request, trailer = _unwrapped(case, service)
            arguments = function.arguments_from_json(case["args"])
            encoded = function.encode_request(arguments)
            yield from _compare("request", request, encoded)
            decoded = function.arguments_to_json(function.decode_request(request))
            items = function.layout.arguments
            yield from _compare_values("arguments", items, case["args"], decoded)
            yield from _compare("trailer", case.get("after_response", ""), trailer)
            if function.oneway:
                yield from _compare("reply", bytes.fromhex(case["response"]), b"")
            else:
                yield from _reply_differences(case, function, arguments)
        except (ArgumentError, JsonError, RpcError) as error:
            yield str(error)

    def _service(self, name: str, tdr: str) -> Service:
        key = (name, tdr)
        if key not in self._services:
            bits = self._wire.tdr.long_bits
            order = cast(Any, _ORDERS.get(tdr))
            if order is None:
                raise Refusal(f"the data representation {tdr!r} is unknown")
            usual = make_tdr(self._wire.tdr.order).long_bits
            representation = make_tdr(order, long_bits=bits if bits != usual else None)
            wire = Wire(representation, self._wire.reply)
            self._services[key] = service_of(self._unit(name), name, wire)
        return self._services[key]

    def _unit(self, name: str) -> TecsUnit:
        """Return the unit of a signature, with the declarations of its own text."""
        if name not in self._units:
            texts = self._recorded["signatures"]
            if name not in texts:
                raise Refusal(f"the signature {name!r} is missing")
            common = self._recorded.get("allocator_cdl", "")
            unit, diagnostics = read_text(common + texts[name], f"{name}.cdl")
            if has_errors(diagnostics):
                unit, others = read_text(common + "".join(texts.values()), "all.cdl")
                if has_errors(others):
                    raise Refusal(
                        str(next(d for d in diagnostics if has_errors([d])).message)
                    )
            self._units[name] = unit
        return self._units[name]


def _unwrapped(case: Mapping[str, Any], service: Service) -> tuple[bytes, str]:
    """Return the request without the framing of a shared channel, and octets after the reply."""
    request = bytes.fromhex(case["request"])
    if not case.get("shared"):
        return request, ""
    tdr = service.codec.tdr
    begin, end = tdr.int16(SHARED_BEGIN), tdr.int16(SHARED_END)
    if not request.startswith(begin) or not request.endswith(end):
        raise JsonError(
            "a request of a shared channel begins with 3141, ends with 2718"
        )
    oneway = service.functions[case["function"]].oneway
    return request[4:-2], "" if oneway else end.hex()


def _reply_differences(
    case: Mapping[str, Any], function: Function, arguments: tuple[object, ...]
) -> Iterator[str]:
    reply = bytes.fromhex(case["response"])
    kept = function.kept(arguments)
    result = {"return": case["return"], "outs": case["outs"]}
    returned, outs = function.result_from_json(result)
    yield from _compare("reply", reply, function.encode_reply(kept, returned, outs))
    decoded = function.result_to_json(*function.decode_reply(reply, kept))
    returns = (function.layout.returned,)
    expected, actual = {"": case["return"]}, {"": decoded["return"]}
    yield from _compare_values("return value", returns, expected, actual)
    items = function.layout.outs
    yield from _compare_values("outs", items, case["outs"], decoded["outs"])


def _compare(what: str, expected: bytes | str, actual: bytes | str) -> Iterator[str]:
    if expected != actual:
        shown = [v.hex() if isinstance(v, bytes) else v for v in (expected, actual)]
        yield f"{what}: {shown[0]} was recorded, the codec encodes {shown[1]}"


def _compare_values(
    what: str, items: tuple[Item, ...], expected: Json, actual: Json
) -> Iterator[str]:
    if not _is_object(items, expected, actual):
        texts = (json.dumps(expected), json.dumps(actual))
        yield f"{what}: {texts[0]} was recorded, the codec decodes {texts[1]}"


def _is_object(items: tuple[Item, ...], expected: Json, actual: Json) -> bool:
    if not isinstance(expected, dict) or not isinstance(actual, dict):
        return expected is None and actual is None
    return all(
        _is_same(item, expected.get(item.name), actual.get(item.name)) for item in items
    )


def _is_same(item: Item, expected: Json, actual: Json) -> bool:
    if item.pointer and isinstance(actual, list) and isinstance(expected, list):
        pairs = zip(expected, actual, strict=False)
        same = all(_is_equal(item.node, a, b) for a, b in pairs)
        return same and len(expected) == len(actual)
    return _is_equal(item.node, expected, actual)


def _single(value: float) -> float:
    """Return the value rounded to float32_t."""
    return float(struct.unpack("f", struct.pack("f", value))[0])


def _is_equal(node: Node, expected: Json, actual: Json) -> bool:
    """Return whether values are equal; of arrays with `count_is`, counted elements are compared."""
    match node:
        case Nothing():
            return True
        case Basic(Scalar.FLOAT32) if isinstance(expected, int | float):
            return _single(expected) == actual
        case Record(items=items):
            return _is_object(items, expected, actual)
        case FixedArray(element) | Counted(element) if isinstance(expected, list):
            if not isinstance(actual, list):
                return False
            is_cut = isinstance(node, Counted) and node.count is not node.size
            expected = expected[: len(actual)] if is_cut else expected
            pairs = zip(expected, actual, strict=False)
            same = all(_is_equal(element, a, b) for a, b in pairs)
            return same and len(expected) == len(actual)
    return expected == actual
