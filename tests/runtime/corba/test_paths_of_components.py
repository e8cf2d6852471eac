"""Finding a component of another process: by name, path, host, or address."""

from __future__ import annotations

from collections.abc import Iterator
from functools import partial
from typing import Any

import pytest

pytest.importorskip("omniORB", reason="omniORBpy is not installed")

import CosNaming

from rtgen.runtime.corba.name_server import NameServer
from rtgen.runtime.corba.naming import Naming
from rtgen.runtime.corba.orb import Orb
from rtgen.runtime.corba.rt_objects.foreign import Directory
from rtgen.runtime.corba.rt_objects.objects import Exported
from rtgen.runtime.services.transports import ForeignComponent


@pytest.fixture(scope="module")
def orb() -> Iterator[Orb]:
    made = Orb()
    yield made
    made.close()


@pytest.fixture(scope="module")
def servers() -> Iterator[tuple[str, str]]:
    """Yield two naming services; the second one has `lab.host_cxt/X0.rtc` and `Y0.rtc`."""
    with NameServer() as first, NameServer() as second:
        yield first.address, second.address


@pytest.fixture(scope="module")
def bound(orb: Orb, servers: tuple[str, str]) -> Any:
    """Bind any object that answers."""
    address = f"corbaloc::{servers[1]}/NameService"
    root = orb.orb.string_to_object(address)._narrow(CosNaming.NamingContext)
    lab = root.bind_new_context([CosNaming.NameComponent("lab", "host_cxt")])
    lab.bind([CosNaming.NameComponent("X0", "rtc")], root)
    root.bind([CosNaming.NameComponent("Y0", "rtc")], root)
    return root


@pytest.mark.parametrize(
    ("service", "path"),
    [
        (1, "localhost/lab.host_cxt/X0.rtc"),
        (1, ""),
        (1, "localhost/X0.rtc"),
        (0, "{1}/lab.host_cxt/X0.rtc"),
        (0, "corbaname::{1}#lab.host_cxt/X0.rtc"),
        (0, "corbaloc::{1}/NameService"),
        (1, "nobody.invalid/Y0.rtc"),
    ],
)
def test_a_component_is_found(
    orb: Orb, servers: tuple[str, str], bound: Any, service: int, path: str
) -> None:
    found = directory(orb, servers[service], path.format(*servers))
    assert found.find("X0")._is_equivalent(bound)


@pytest.mark.parametrize(
    ("path", "where"),
    [
        ("", "the naming service {0} has no X0.rtc that answers"),
        (
            "127.0.0.1:1/X0.rtc",
            "the naming service {0} has no X0.rtc, nor is anything at 127.0.0.1:1/X0.rtc, "
            "that answers",
        ),
        (
            "corbaname::{1}#Z0.rtc",
            "nothing answers at corbaname::{1}#Z0.rtc",
        ),
        ("IOR:00", "nothing answers at IOR:00"),
    ],
)
def test_a_component_is_missing(
    orb: Orb, servers: tuple[str, str], bound: Any, path: str, where: str
) -> None:
    found = directory(orb, servers[0], path.format(*servers))
    assert found.find("X0") is None
    assert found.where("X0") == where.format(*servers)


def directory(orb: Orb, service: str, path: str) -> Directory:
    opened = partial(Naming, orb.orb)
    made = Directory(opened(service), Exported(orb), opened)
    made.add(ForeignComponent("X0", path))
    return made
