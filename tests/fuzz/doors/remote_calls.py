"""Doors for remote calls: OpaqueRPC on both sides, bodies of GIOP, and DDS-RPC."""

from __future__ import annotations

import json
import sys
from collections.abc import Callable
from contextlib import suppress
from functools import cache, partial
from itertools import chain
from pathlib import Path
from random import Random
from typing import Any, cast

import octets
from fuzzing import log_uniform
from generated import Generated, generate

from doors import Door
from doors.mixing import ROOT, mixing
from rtgen.compiler.frontends import cdl, idl
from rtgen.compiler.layouts.tdr import TransferError
from rtgen.compiler.model.tecs import Signature
from rtgen.runtime import Servant, ServiceError, Stub
from rtgen.runtime.cdr import CdrError, UserException
from rtgen.runtime.distribution import rpc_header
from rtgen.runtime.distribution.medium import representation
from rtgen.runtime.distribution.rpc_calls import RpcClient, RpcServer
from rtgen.runtime.distribution.rpc_types import OK, interface_types
from rtgen.runtime.opaque_rpc import ArgumentError, RpcError, make_tdr
from rtgen.runtime.opaque_rpc.messages import PacketReader, serve_message
from rtgen.runtime.opaque_rpc.tdr import EOP_NOTHING_FOLLOWS, EOP_REPLY_FOLLOWS
from rtgen.runtime.services.calls import (
    Client,
    Reply,
    ReplyStatus,
    Server,
    calls_of,
)
from rtgen.runtime.xcdr import serialize
from rtgen.tools.rpc.board import MockBoard, ScriptError
from rtgen.tools.rpc.codecs import Function, Service

_FILES = (
    "tests/compiler/cdl/constructs.cdl",
    "specs/tecs/board.cdl",
    "tests/fuzz/calls.cdl",
)
_HEADER_LENGTH = 2
"""Octets before a message: the number of its reader."""
_ORDERS = ("network", "little", "big")


@cache
def _services() -> tuple[Service, ...]:
    """Return the services of this repository that OpaqueRPC can carry, in each byte order."""
    found = []
    for path in _FILES:
        for unit in cdl.load([ROOT / path], root=ROOT).model.tecs:
            for declared in unit.declarations:
                if isinstance(declared, Signature):
                    for order in _ORDERS:
                        try:
                            found.append(Service(unit, declared, make_tdr(order)))
                        except TransferError:
                            break
    return tuple(found)


@cache
def _functions() -> tuple[Function, ...]:
    return tuple(f for s in _services() for f in s.functions.values())


def _padded(function: Function, octets: bytes) -> tuple[object, ...]:
    """Return the arguments encoded in octets, padded with zeros if they are too short."""
    rest = octets
    end = function._codec.tdr.int16(
        EOP_NOTHING_FOLLOWS if function.oneway else EOP_REPLY_FOLLOWS
    )

    def more(n: int) -> bytes:
        nonlocal rest
        found, rest = rest[:n], rest[n:]
        return end if n == len(end) and not found else found.ljust(n, b"\0")

    return function.read_request(more)


def _requests() -> list[bytes]:
    """Return for each service a request of each function with arguments of zeros."""
    found = []
    for number, service in enumerate(_services()):
        for function in service.functions.values():
            with suppress(RpcError, ArgumentError):
                arguments = _padded(function, b"")
                found.append(bytes((number,)) + function.encode_request(arguments))
    return found


def _octets(seeds: list[bytes], chance: Random) -> bytes:
    data = bytearray(chance.choice(seeds))
    for _ in range(log_uniform(1, 12, chance.random())):
        at = chance.randrange(len(data) + 1)
        match chance.randrange(4):
            case 0:
                del data[at : at + chance.choice((1, 2, 4))]
            case 1:
                data[at : at + 1] = chance.randbytes(1)
            case 2:
                data[at:at] = bytes(chance.choice((1, 2, 4, 8)))
            case _:
                word = chance.choice(
                    (0, 1, 2, 3, 255, 0x7FFF, 0x10000, 0x7FFFFFFF, 0xFFFFFFFF)
                )
                order: str = chance.choice(("big", "little"))
                data[at : at + 4] = word.to_bytes(4, order)  # type: ignore[arg-type]
    return bytes(data)


def _rpc_server(_folder: Path) -> Door:
    boards = [MockBoard(service) for service in _services()]
    seeds = _requests()

    def enter(data: bytes) -> bool:
        board = boards[data[0] % len(boards) if data else 0]
        try:
            serve_message(PacketReader(data[1:], 4096), board.handlers)
        except RpcError:
            return False
        return True

    return Door(enter, partial(_octets, seeds), seeds)


def _tdr(_folder: Path) -> Door:
    """Return the door for arguments of a function, which are encoded again once decoded."""
    functions = _functions()
    seeds = [bytes((n % 256, n // 256)) for n in range(len(functions))]

    def enter(data: bytes) -> bool:
        function = functions[int.from_bytes(data[:2], "little") % len(functions)]
        try:
            arguments = _padded(function, data[2:])
            written = function.encode_request(arguments)
        except (RpcError, ArgumentError):
            return False
        again = function.encode_request(function.decode_request(written))
        if again != written:
            raise AssertionError(
                f"{function.name}: {written.hex()} became {again.hex()}"
            )
        return True

    return Door(enter, partial(_octets, seeds), seeds)


def _rpc_client(_folder: Path) -> Door:
    functions = [f for f in _functions() if not f.oneway]
    seeds = [
        bytes((n % 256, n // 256)) + b"\x56\x1e" + bytes(8) + b"\x6d\x5e"
        for n in range(len(functions))
    ]

    def enter(data: bytes) -> bool:
        function = functions[int.from_bytes(data[:2], "little") % len(functions)]
        for guess in function.guesses(3):
            try:
                function.decode_reply(data[2:], guess)
            except RpcError:
                continue
            return True
        return False

    return Door(enter, partial(_octets, seeds), seeds)


def _rpc_script(_folder: Path) -> Door:
    """Return the door for the lines of JSON of `rtgen rpc serve --script`."""
    services = _services()
    lines = [
        json.dumps(
            {"function": name, "args": {}, "return": 0, "outs": {}, "delay": 0.5}
        )
        for service in services[::3]
        for name in service.functions
    ]
    seeds = [line.encode() for line in lines] + [b"1", b"null", b"[]"]

    def enter(data: bytes) -> bool:
        try:
            for service in services[::3]:
                MockBoard(service, data.decode("utf-8", "replace"))
        except ScriptError:
            return False
        return True

    return Door(enter, mixing(seeds), seeds)


@cache
def _operations() -> tuple[tuple[type[Servant], str], ...]:
    """Return the operations of all interfaces of a definition with every construct."""
    path = octets.CONSTRUCTS[-1]
    made = Generated(generate(idl.load([path], root=path.parent).model))
    modules = made.load().values()
    # Types of operations are imported on their first use.
    sys.meta_path.insert(0, made)
    found: list[tuple[type[Servant], str]] = []
    for value in chain.from_iterable(vars(module).values() for module in modules):
        if not isinstance(value, type) or not issubclass(value, Servant):
            continue
        if value.__module__.startswith("fuzzed") and not issubclass(value, Stub):
            calls = calls_of(value)
            found += ((value, n) for n in sorted(calls) if not calls[n].refused)
    return tuple(dict.fromkeys(found))


def _nothing(_operation: str, _arguments: tuple[object, ...]) -> None:
    """Return None, which is the result of few operations."""


def _giop_server(_folder: Path) -> Door:
    known = [
        (Server.of(interface, _nothing), name) for interface, name in _operations()
    ]
    seeds = [
        bytes((n, little)) + bytes(16) for n in range(len(known)) for little in (0, 1)
    ]

    def enter(data: bytes) -> bool:
        data = data.ljust(2, b"\0")
        server, name = known[data[0] % len(known)]
        reply = server.handle(name, data[2:], bool(data[1] & 1))
        return reply is None or reply.status is not ReplyStatus.SYSTEM_EXCEPTION

    return Door(enter, partial(_octets, seeds), seeds)


def _giop_client(_folder: Path) -> Door:
    def send(_operation: str, _body: bytes, _oneway: bool) -> None:
        """Send nothing: replies are passed to the client directly."""

    known = [(Client(interface, send), name) for interface, name in _operations()]
    seeds = [
        bytes((n, status)) + bytes(16) for n in range(len(known)) for status in range(3)
    ]

    def enter(data: bytes) -> bool:
        data = data.ljust(2, b"\0")
        client, name = known[data[0] % len(known)]
        status = ReplyStatus(data[1] % len(ReplyStatus))
        reply = Reply(status, data[2:], bool(data[1] & 0x80))
        try:
            client._result(name, client._calls[name], reply)
        except (ServiceError, UserException, CdrError):
            return False
        return True

    return Door(enter, partial(_octets, seeds), seeds)


@cache
def _rpc_interfaces() -> tuple[type[Servant], ...]:
    """Return the interfaces that DDS and Zenoh carry."""
    return tuple(dict.fromkeys(interface for interface, _ in _operations()))


def _head(number: int) -> bytes:
    return number.to_bytes(_HEADER_LENGTH, "little")


def _dds_rpc_server(_folder: Path) -> Door:
    """Return the door for requests by DDS-RPC's basic mapping with headers, as on DDS and Zenoh."""
    known = [(RpcServer(i, _nothing), interface_types(i)) for i in _rpc_interfaces()]
    seeds = []
    for number, (_, types) in enumerate(known):
        for operation in types.operations.values():
            with suppress(CdrError, TypeError):
                call = types.call(operation.label, operation.request())
                request = types.request(rpc_header.Identities().header(), call)
                request.header.request_id.writer_guid = rpc_header.Guid()
                octets_ = serialize(request, representation(types.request))
                seeds.append(_head(number) + octets_)

    def enter(data: bytes) -> bool:
        server, _ = known[int.from_bytes(data[:_HEADER_LENGTH], "little") % len(known)]
        request = data[_HEADER_LENGTH:]
        with suppress(CdrError):
            rpc_header.server_of(request)
        try:
            rpc_header.identity_of(request)
            identity, operation, value = server.request(request)
        except CdrError:
            return False
        rpc_header.identity_of(server.answer(identity, operation, value))
        return operation is not None

    return Door(enter, partial(_octets, seeds), seeds)


def _dds_rpc_client(_folder: Path) -> Door:
    """Return the door for replies of the same mapping."""
    known = [
        (i, name) for i, name in _operations() if name in interface_types(i).operations
    ]
    seeds = []
    for number, (interface, name) in enumerate(known):
        types = interface_types(interface)
        operation = types.operations[name]
        for label in (OK, *operation.exceptions):
            with suppress(CdrError, TypeError):
                kind = (
                    operation.reply if label == OK else operation.exceptions[label][0]
                )
                answer = types.answer(operation.label, operation.result(label, kind()))
                reply = types.reply(rpc_header.ReplyHeader(), answer)
                octets_ = serialize(reply, representation(types.reply))
                seeds.append(_head(number) + octets_)
    nobody = cast(Any, None)
    clients = {i: RpcClient(i, nobody, 1.0) for i, _ in known}

    def enter(data: bytes) -> bool:
        interface, name = known[
            int.from_bytes(data[:_HEADER_LENGTH], "little") % len(known)
        ]
        operation = interface_types(interface).operations[name]
        try:
            clients[interface]._result(name, operation, data[_HEADER_LENGTH:])
        except (ServiceError, UserException, CdrError):
            return False
        return True

    return Door(enter, partial(_octets, seeds), seeds)


DOORS: dict[str, Callable[[Path], Door]] = {
    "tdr": _tdr,
    "rpc-server": _rpc_server,
    "rpc-client": _rpc_client,
    "rpc-script": _rpc_script,
    "giop-server": _giop_server,
    "giop-client": _giop_client,
    "dds-rpc-server": _dds_rpc_server,
    "dds-rpc-client": _dds_rpc_client,
}
