"""Doors of floods.py other than the page: Foxglove's server, CAN, remote control, CORBA."""

from __future__ import annotations

import json
import socket
import struct
import subprocess
import sys
import threading
import time
from collections.abc import Callable, Iterator
from contextlib import ExitStack, closing, contextmanager, suppress
from typing import Any

from floods import INSTANCE, PORT, STEERED, SYSTEM, Door, Gaps

Address = Callable[[bool], str]
_LONG = 1e6
_THREADS = 8
_CALLED = "RefHardRh30"


@contextmanager
def running(transport: Any, stack: ExitStack) -> Iterator[tuple[Any, Gaps]]:
    """Run the system in a thread; what is in `stack` is closed before the system."""
    from rtgen import runtime
    from rtgen.compiler.project import load_around
    from rtgen.compiler.systems.reading import read_file
    from rtgen.tools.running.assembly import assemble
    from rtgen.tools.running.factories import Factories

    profile, _, _ = read_file(SYSTEM)
    assert profile is not None
    factories, clock = Factories(load_around(SYSTEM)), runtime.RealClock()
    ended = threading.Event()
    with assemble(profile, factories, clock, [], [], transport) as system, stack:
        gaps = Gaps()
        system.watch_port(INSTANCE, PORT, gaps.tick)
        thread = threading.Thread(
            target=lambda: system.run(round(_LONG * 1e9), lambda _: ended.is_set())
        )
        thread.start()
        try:
            yield system, gaps
        finally:
            ended.set()
            thread.join()


def steer(
    request: Callable[[str], bool], ready: Any, end: Any, longest: Any, refused: Any
) -> None:
    """Deactivate and activate a component until the end."""
    number = 0
    while not end.wait(0.3):
        for what in ("deactivate", "activate"):
            number += 1
            begun = time.perf_counter()
            done = request(what)
            passed = time.perf_counter() - begun
            if what == "deactivate":
                longest.value = max(longest.value, passed)
            refused.value += not done
            time.sleep(0.05)
        if number > 4:
            ready.set()


# Foxglove.


@contextmanager
def foxglove() -> Iterator[tuple[Address, Gaps]]:
    """Run the system behind a live view."""
    from rtgen.tools.recording import live_view

    with ExitStack() as stack, running(None, stack) as (system, gaps):
        view = live_view.LiveView(system, "floods", port=0)
        stack.callback(view.close)
        yield lambda _: view.address, gaps


class Viewer:
    """A client of Foxglove's protocol."""

    def __init__(self, address: str) -> None:
        from websockets.sync.client import connect

        self.socket = connect(address, subprotocols=["foxglove.sdk.v1"], max_size=None)
        self.services: dict[str, int] = {}
        while STEERED not in str(self.services):
            message = self.socket.recv(60)
            if isinstance(message, str):
                found = json.loads(message)
                listed = found.get("services", ())
                self.services |= {each["name"]: each["id"] for each in listed}

    def call(self, name: str, number: int) -> None:
        """Send a call of a service."""
        head = struct.pack("<BIII", 2, self.services[name], number, 4)
        self.socket.send(head + b"json" + b"{}")

    def answer(self, number: int) -> bool:
        """Return whether a call was executed."""
        while True:
            message = self.socket.recv(60)
            if isinstance(message, str):
                found = json.loads(message)
                if found.get("op") == "serviceCallFailure":
                    return False
            elif message[0] == 3 and struct.unpack_from("<I", message, 5)[0] == number:
                return True


def flood_foxglove(address: str, kind: str, ready: Any, end: Any, answers: Any) -> None:
    """Read parameters or call a service, hundred requests at a time."""
    viewer = Viewer(address)
    question = json.dumps({"op": "getParameters", "parameterNames": [], "id": "f"})
    [name] = [n for n in viewer.services if n.endswith("/RefHard/Stop")][:1]
    ready.set()
    while not end.is_set():
        for _ in range(100):
            if kind == "foxglove parameters":
                viewer.socket.send(question)
            else:
                viewer.call(name, 7)
        for _ in range(100):
            viewer.socket.recv(60)
            answers.value += 1


_UNREAD: dict[str, str | bytes] = {
    "foxglove unread": json.dumps(
        {"op": "getParameters", "parameterNames": [], "id": "f"}
    ),
    "foxglove subscriptions": json.dumps(
        {"op": "subscribe", "subscriptions": [{"id": 1, "channelId": 1}]}
    ),
    "foxglove garbage": b"\xff" * 10,
}


def flood_unread(address: str, kind: str, ready: Any, end: Any, answers: Any) -> None:
    """Send messages without waiting for answers, which a thread of the library reads."""
    from websockets.exceptions import ConnectionClosed

    while not end.is_set():
        with suppress(ConnectionClosed, OSError, EOFError):
            viewer = Viewer(address)
            ready.set()
            reader = threading.Thread(
                target=_count, args=(viewer, answers), daemon=True
            )
            reader.start()
            while not end.is_set():
                viewer.socket.send(_UNREAD[kind])


def flood_joins(address: str, kind: str, ready: Any, end: Any, answers: Any) -> None:
    """Open and close connections."""
    from websockets.exceptions import ConnectionClosed, InvalidMessage

    while not end.is_set():
        with suppress(ConnectionClosed, InvalidMessage, OSError, EOFError):
            Viewer(address).socket.close()
            answers.value += 1
            ready.set()


def _count(viewer: Viewer, answers: Any) -> None:
    from websockets.exceptions import ConnectionClosed

    with suppress(ConnectionClosed, OSError, EOFError):
        while True:
            viewer.socket.recv(60)
            answers.value += 1


def operate_foxglove(
    address: str, ready: Any, end: Any, longest: Any, refused: Any
) -> None:
    """Steer by services."""
    viewer = Viewer(address)
    numbers = iter(range(1, 1 << 30))

    def request(what: str) -> bool:
        number = next(numbers)
        viewer.call(f"/{STEERED}/{what}", number)
        return viewer.answer(number)

    steer(request, ready, end, longest, refused)


# CAN.


class Listener:
    """A station that receives all frames."""

    identifiers = deadline = None
    received = 0

    def receive(self, frame: Any, now: int) -> tuple[Any, ...]:
        """Count a frame."""
        self.received += 1
        return ()

    def poll(self, now: int) -> tuple[Any, ...]:
        """Do nothing."""
        return ()

    def link_changed(self, up: bool, now: int) -> tuple[Any, ...]:
        """Do nothing."""
        return ()


@contextmanager
def can() -> Iterator[tuple[Address, Gaps]]:
    """Run the system behind a live view, with a station on a bus of `rtgen can hub`."""
    from rtgen.runtime.canopen.bus.python_can import BusAddress
    from rtgen.runtime.canopen.bus.real_link import RealLink
    from rtgen.tools.recording import live_view

    hub = [
        sys.executable,
        "-m",
        "rtgen",
        "can",
        "hub",
        "--port",
        "0",
        "--bitrate",
        "1000000",
    ]
    with (
        subprocess.Popen(hub, stdout=subprocess.PIPE, text=True) as program,
        ExitStack() as stack,
        running(None, stack) as (system, gaps),
    ):
        stack.callback(program.terminate)
        assert program.stdout is not None
        port = int(program.stdout.readline().rpartition(":")[2])
        options = (("host", "127.0.0.1"), ("port", port))
        address = BusAddress("socketcand", "flood", options=options)
        link = RealLink(address, lambda: None, lambda: True)
        stack.callback(link.close)
        link.attach(Listener())
        view = live_view.LiveView(system, "floods", port=0)
        stack.callback(view.close)
        yield lambda full: view.address if full else str(port), gaps


def flood_can(address: str, kind: str, ready: Any, end: Any, answers: Any) -> None:
    """Send frames as fast as the hub takes them."""
    with socket.create_connection(("127.0.0.1", int(address))) as bus:
        bus.recv(256)
        for command in (b"< open flood >", b"< rawmode >"):
            bus.sendall(command)
            bus.recv(256)
        ready.set()
        reader = threading.Thread(target=_discard, args=(bus,), daemon=True)
        reader.start()
        while not end.is_set():
            bus.sendall(b"< send 123 8 1 2 3 4 5 6 7 8 >" * 100)
            answers.value += 100


def _discard(bus: socket.socket) -> None:
    with suppress(OSError):
        while bus.recv(1 << 16):
            pass


# Remote control.


@contextmanager
def zenoh() -> Iterator[tuple[Address, Gaps]]:
    """Run the system over Zenoh."""
    from media import transports

    with (
        transports("zenoh") as others,
        others.open(2.0) as transport,
        ExitStack() as stack,
        running(transport, stack) as (_, gaps),
    ):
        yield lambda _: str(others.address), gaps


def flood_control(address: str, kind: str, ready: Any, end: Any, answers: Any) -> None:
    """Ask from eight threads for a state or a description."""
    from media import transport_at

    from rtgen.runtime.distribution.control import ControlError

    with transport_at(address, 5.0) as transport:
        transport.await_instance(INSTANCE, 60.0)
        askers = [transport.peers.asker(INSTANCE) for _ in range(_THREADS)]

        def ask(number: int) -> None:
            with suppress(ControlError):
                asker = askers[number]
                asker.state() if kind == "ctl state" else asker.describe()

        _repeat(ask, ready, end, answers)


def flood_calls(address: str, kind: str, ready: Any, end: Any, answers: Any) -> None:
    """Call an operation of a service port from eight threads."""
    from media import medium_at, transport_at

    from refrobots import RefHard
    from rtgen.runtime.distribution.names import service_name
    from rtgen.runtime.distribution.services import RemoteCalls
    from rtgen.runtime.services.servants import ServiceError

    with transport_at(address, 5.0) as transport:
        transport.await_instance(_CALLED, 60.0)
    service = service_name(_CALLED, "InventGUIRefHard", "RefHard")
    with closing(medium_at(address)) as medium:
        clients = [RemoteCalls(medium, RefHard, service, 5.0) for _ in range(_THREADS)]

        def call(number: int) -> None:
            with suppress(ServiceError):
                clients[number].invoke("Stop", ())

        _repeat(call, ready, end, answers)


def _repeat(work: Callable[[int], object], ready: Any, end: Any, answers: Any) -> None:
    """Do the work in threads, each with a number, until the end."""

    def repeat(number: int) -> None:
        while not end.is_set():
            work(number)
            answers.value += 1

    threads = [threading.Thread(target=repeat, args=(n,)) for n in range(_THREADS)]
    for thread in threads:
        thread.start()
    ready.set()
    for thread in threads:
        thread.join()


def operate_control(
    address: str, ready: Any, end: Any, longest: Any, refused: Any
) -> None:
    """Steer by remote control."""
    from media import transport_at

    from rtgen.runtime.distribution.control import ControlError

    with transport_at(address, 5.0) as transport:
        transport.await_instance(STEERED, 60.0)
        asker = transport.peers.asker(STEERED)

        def request(what: str) -> bool:
            try:
                getattr(asker, what)()
            except ControlError:
                return False
            return True

        steer(request, ready, end, longest, refused)


# CORBA.


@contextmanager
def corba() -> Iterator[tuple[Address, Gaps]]:
    """Run the system over CORBA."""
    from media import transports

    with (
        transports("corba") as others,
        others.open(2.0) as transport,
        ExitStack() as stack,
        running(transport, stack) as (_, gaps),
    ):
        yield lambda _: str(others.address), gaps


def _remote(address: str, instance: str) -> Any:
    from rtgen.runtime.corba.orb import Orb
    from rtgen.runtime.corba.rt_objects.objects import Exported
    from rtgen.runtime.corba.rt_objects.remote import RemoteRtc

    orb = Orb(timeout=5.0)
    place = json.loads(address)["corba"]
    name = f"corbaname::{place}#{instance}.rtc"
    return RemoteRtc(orb.orb.string_to_object(name), Exported(orb))


def flood_corba(address: str, kind: str, ready: Any, end: Any, answers: Any) -> None:
    """Ask from eight threads for a profile or a state, or call an operation of a service port."""
    from refrobots import RefHard
    from rtgen.runtime.corba.objects import Objects
    from rtgen.runtime.corba.orb import Orb
    from rtgen.runtime.services.servants import ServiceError

    if kind == "corba calls":
        orb = Orb(timeout=5.0)
        place = json.loads(address)["corba"]
        name = f"corbaname::{place}#{_CALLED}.InventGUIRefHard/RefHard"
        remote = Objects(orb).remote(RefHard, orb.orb.string_to_object(name))

        def call(_: int) -> None:
            with suppress(ServiceError):
                remote.call("Stop", ())

        _repeat(call, ready, end, answers)
        return
    rtc = _remote(address, INSTANCE)
    context = rtc.context
    if kind == "corba profile":
        _repeat(lambda _: rtc.call("get_component_profile"), ready, end, answers)
        return
    state = "get_component_state"
    _repeat(lambda _: rtc.ask(context, state, rtc.reference), ready, end, answers)


def operate_corba(
    address: str, ready: Any, end: Any, longest: Any, refused: Any
) -> None:
    """Steer by the execution context."""
    rtc = _remote(address, STEERED)

    def request(what: str) -> bool:
        rtc.ask(rtc.context, f"{what}_component", rtc.reference)
        return True

    steer(request, ready, end, longest, refused)


DOORS = {
    "foxglove parameters": Door(foxglove, flood_foxglove, operate_foxglove),
    "foxglove calls": Door(foxglove, flood_foxglove, operate_foxglove),
    "foxglove joins": Door(foxglove, flood_joins, operate_foxglove),
    **{kind: Door(foxglove, flood_unread, operate_foxglove) for kind in _UNREAD},
    "can frames": Door(can, flood_can, operate_foxglove),
    "ctl state": Door(zenoh, flood_control, operate_control),
    "ctl describe": Door(zenoh, flood_control, operate_control),
    "zenoh calls": Door(zenoh, flood_calls, operate_control),
    "corba profile": Door(corba, flood_corba, operate_corba),
    "corba state": Door(corba, flood_corba, operate_corba),
    "corba calls": Door(corba, flood_corba, operate_corba),
}
