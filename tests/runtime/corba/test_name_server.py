"""The naming service that a run starts for itself."""

from __future__ import annotations

import socket
import threading

import pytest

from rtgen.runtime.corba import name_server

LOCATE_REPLY = b"GIOP\x01\x00\x01\x04\x08\x00\x00\x00\x01\x00\x00\x00"


@pytest.mark.parametrize(
    ("answer", "there"),
    [
        (LOCATE_REPLY + b"\x01\x00\x00\x00", True),
        (LOCATE_REPLY + b"\x00\x00\x00\x00", False),
        (LOCATE_REPLY, False),
        (b"", False),
    ],
    ids=["here", "unknown", "cut", "closed"],
)
def test_a_port_that_listens_is_not_yet_a_naming_service(
    answer: bytes, there: bool
) -> None:
    with socket.create_server(("127.0.0.1", 0)) as server:

        def reply() -> None:
            connection, _ = server.accept()
            with connection:
                assert connection.recv(1024).endswith(b"\x0b\x00\x00\x00NameService")
                connection.sendall(answer)

        thread = threading.Thread(target=reply)
        thread.start()
        assert name_server._has_root(server.getsockname()[1]) is there
        thread.join()


def test_a_naming_service_has_its_root_when_it_is_there() -> None:
    pytest.importorskip("omniORB", reason="omniORBpy is not installed")
    with name_server.NameServer() as service:
        port = int(service.address.rpartition(":")[2])
        assert name_server._has_root(port)
    assert not name_server._has_root(port)
