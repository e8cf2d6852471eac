"""Calls to a process that accepts connections, and does not answer."""

from __future__ import annotations

import socket
import threading
from collections.abc import Iterator
from typing import Any

import pytest

pytest.importorskip("omniORB", reason="omniORBpy is not installed")

from omniORB import CORBA
from patience import PATIENCE

from rtgen.runtime.corba.iors import place
from rtgen.runtime.corba.orb import Orb
from rtgen.runtime.corba.rt_objects.objects import Exported
from rtgen.runtime.corba.rt_objects.wire import EXECUTION_CONTEXT, PORT_SERVICE

pytestmark = pytest.mark.waits


class Silent:
    """A process that reads requests only."""

    def __init__(self) -> None:
        self.octets = b""
        self.arrived = threading.Condition()
        self._socket = socket.create_server(("127.0.0.1", 0))
        self.place = f"127.0.0.1:{self._socket.getsockname()[1]}"
        self._thread = threading.Thread(target=self._accept, daemon=True)
        self._thread.start()

    def _accept(self) -> None:
        while True:
            try:
                connection, _ = self._socket.accept()
            except OSError:
                return
            threading.Thread(target=self._read, args=(connection,), daemon=True).start()

    def _read(self, connection: socket.socket) -> None:
        with connection:
            while octets := connection.recv(4096):
                with self.arrived:
                    self.octets += octets
                    self.arrived.notify_all()

    def close(self) -> None:
        self._socket.shutdown(socket.SHUT_RDWR)
        self._socket.close()
        self._thread.join()


@pytest.fixture
def silent() -> Iterator[Silent]:
    made = Silent()
    yield made
    made.close()


@pytest.fixture
def exported() -> Iterator[Exported]:
    orb = Orb(timeout=1.0)
    yield Exported(orb)
    orb.close()


def port_of(exported: Exported, silent: Silent, key: str) -> Any:
    return exported.reference(f"corbaloc::{silent.place}/{key}")


def test_the_first_call_alone_waits(exported: Exported, silent: Silent) -> None:
    one, other = (port_of(exported, silent, key) for key in ("one", "other"))
    assert place(exported.text(one)) == silent.place
    for reference in (one, other, one):
        with pytest.raises((CORBA.TIMEOUT, CORBA.TRANSIENT)):
            exported.call(reference, PORT_SERVICE, "get_port_profile")
    assert silent.octets.count(b"get_port_profile") == 1


def test_another_process_is_called(exported: Exported, silent: Silent) -> None:
    further = Silent()
    try:
        for each in (silent, further):
            with pytest.raises((CORBA.TIMEOUT, CORBA.TRANSIENT)):
                exported.call(
                    port_of(exported, each, "x"), PORT_SERVICE, "get_port_profile"
                )
            assert b"get_port_profile" in each.octets
    finally:
        further.close()


def test_a_posted_request_is_sent_nevertheless(
    exported: Exported, silent: Silent
) -> None:
    context = port_of(exported, silent, "context")
    with pytest.raises((CORBA.TIMEOUT, CORBA.TRANSIENT)):
        exported.call(context, EXECUTION_CONTEXT, "get_component_state", context)
    exported.post(context, EXECUTION_CONTEXT, "deactivate_component", context)
    with silent.arrived:
        assert silent.arrived.wait_for(
            lambda: b"deactivate_component" in silent.octets, PATIENCE
        )
