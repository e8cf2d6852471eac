"""All names of a naming service: in order, in any number, with any characters."""

from __future__ import annotations

import socket
from collections.abc import Iterator
from contextlib import closing
from typing import Any

import pytest
from forwarder import Forwarder
from patience import PATIENCE

pytest.importorskip("omniORB", reason="omniORBpy is not installed")

import CosNaming

from rtgen.runtime.corba.name_server import NameServer
from rtgen.runtime.corba.naming import Naming
from rtgen.runtime.corba.orb import LOOPBACK, Orb
from rtgen.runtime.errors import NoNamingServiceError

MANY = 250
"""More names than a naming service lists at once."""


@pytest.fixture
def orb() -> Iterator[Any]:
    with closing(Orb()) as made:
        yield made.orb


@pytest.fixture
def service(orb: Any) -> Iterator[tuple[Naming, Any]]:
    """Yield a client of a naming service, and its root."""
    with NameServer() as server:
        root = orb.string_to_object(f"corbaloc::{server.address}/NameService")
        yield Naming(orb, server.address), root._narrow(CosNaming.NamingContext)


def named(id_: str, kind: str = "") -> list[Any]:
    return [CosNaming.NameComponent(id_, kind)]


def paths(naming: Naming) -> list[str]:
    return [bound.text for bound in naming.tree()]


def test_names_come_after_their_contexts(service: tuple[Naming, Any]) -> None:
    naming, root = service
    host = root.bind_new_context(named("rh3", "host_cxt"))
    inner = host.bind_new_context(named("arms"))
    inner.bind(named("Arm0", "rtc"), root)
    root.bind(named("A/b.c\\d", "rtc"), root)
    assert paths(naming) == [
        "A\\/b\\.c\\\\d.rtc",
        "rh3.host_cxt",
        "rh3.host_cxt/arms",
        "rh3.host_cxt/arms/Arm0.rtc",
    ]
    contexts = [bound.reference is None for bound in naming.tree()]
    assert contexts == [False, True, True, False]


def test_all_names_are_listed_up_to_a_number(service: tuple[Naming, Any]) -> None:
    naming, root = service
    for number in range(MANY):
        root.bind(named(f"{number:03}"), root)
    assert paths(naming) == [f"{number:03}" for number in range(MANY)]
    assert len(naming.tree(7)) == 7


def test_a_context_that_contains_itself_is_entered_once(
    service: tuple[Naming, Any],
) -> None:
    naming, root = service
    inner = root.bind_new_context(named("inner"))
    inner.bind_context(named("outer"), root)
    inner.bind_context(named("self"), inner)
    assert paths(naming) == ["inner", "inner/outer", "inner/self"]


def test_calls_have_the_time_out_of_their_orb_even_if_the_process_has_another_one() -> (
    None
):
    with (
        closing(Orb(timeout=0.1)) as first,
        closing(Orb(timeout=PATIENCE)) as second,
        NameServer() as server,
    ):
        _, _, port = server.address.partition(":")
        for limit in (None, second.limit):
            near = socket.create_server((LOOPBACK, 0))
            address = f"{LOOPBACK}:{near.getsockname()[1]}"
            late = Forwarder(near, (LOOPBACK, int(port)), delay=0.5)
            try:
                if limit is None:
                    with pytest.raises(NoNamingServiceError):
                        Naming(first.orb, address)
                else:
                    assert Naming(first.orb, address, limit).tree() == []
            finally:
                late.close()
