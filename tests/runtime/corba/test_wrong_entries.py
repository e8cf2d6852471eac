"""Entries of a naming service that lead nowhere, and services that answer wrongly."""

from __future__ import annotations

import socket
import subprocess
import sys
from collections.abc import Callable, Iterator
from concurrent.futures import ThreadPoolExecutor
from contextlib import closing, suppress
from pathlib import Path
from typing import Any

import pytest

pytest.importorskip("omniORB", reason="omniORBpy is not installed")

import CosNaming
import CosNaming__POA
from patience import PATIENCE
from wrong_naming_service import FAULTS

from rtgen.runtime.corba.name_server import NameServer
from rtgen.runtime.corba.naming import Naming
from rtgen.runtime.corba.orb import LOOPBACK, Orb
from rtgen.runtime.errors import TransportError

pytestmark = pytest.mark.waits

HOST = ("gone", "host_cxt")
PORT = ("Counter0", "adding")
DEPTH = 1100
"""More contexts within each other than Python has calls."""


@pytest.fixture
def orb() -> Iterator[Orb]:
    with closing(Orb(timeout=0.5)) as made:
        yield made


@pytest.fixture
def service(orb: Orb) -> Iterator[tuple[Naming, Any]]:
    """Yield a client of a naming service, and its root."""
    with NameServer() as server:
        naming = Naming(orb.orb, server.address, orb.limit)
        yield naming, naming._root


@pytest.fixture
def silent() -> Iterator[str]:
    """Yield the address of a process that accepts connections, and does not answer."""
    with socket.create_server((LOOPBACK, 0)) as server:
        yield f"{LOOPBACK}:{server.getsockname()[1]}"


@pytest.fixture
def wrong() -> Iterator[Callable[[str], str]]:
    """Yield a function that starts a naming service with a fault, and returns its address."""
    script = str(Path(__file__).with_name("wrong_naming_service.py"))
    processes: list[subprocess.Popen[str]] = []

    def started(fault: str) -> str:
        process = subprocess.Popen(
            [sys.executable, script, fault],
            stdin=subprocess.PIPE,
            stdout=subprocess.PIPE,
            text=True,
        )
        processes.append(process)
        assert process.stdout is not None
        return process.stdout.readline().strip()

    yield started
    for process in processes:
        process.communicate(timeout=PATIENCE)


def named(id_: str, kind: str = "") -> list[Any]:
    return [CosNaming.NameComponent(id_, kind)]


def at(orb: Orb, address: str) -> Any:
    """Return a reference to a naming service, whether it is there or not."""
    return orb.orb.string_to_object(f"corbaloc::{address}/NameService")


class Servant(CosNaming__POA.BindingIterator):  # type: ignore[misc]
    """An object that is no context."""


def entry(kind: str, orb: Orb, silent: str, wrong: Callable[[str], str]) -> Any:
    """Return what is bound in the place of a context."""
    if kind in FAULTS:
        return at(orb, wrong(kind))
    if kind == "nil":
        return None
    if kind == "of another type":
        return orb.activate(Servant())
    reference = at(orb, silent if "silent" in kind else f"{LOOPBACK}:1")
    # What says that it is a context is not asked.
    is_typed = kind.endswith("context")
    return (
        reference._unchecked_narrow(CosNaming.NamingContext) if is_typed else reference
    )


NOWHERE = ("nil", "gone", "gone context", "silent", "silent context")


@pytest.mark.parametrize("kind", [*NOWHERE, "of another type", *FAULTS])
def test_an_entry_hides_no_other_one(
    kind: str,
    orb: Orb,
    service: tuple[Naming, Any],
    silent: str,
    wrong: Callable[[str], str],
) -> None:
    naming, root = service
    root.bind_context(named(*HOST), entry(kind, orb, silent, wrong))
    host = root.bind_new_context(named("rh3", "host_cxt"))
    host.bind(named("Arm0", "rtc"), root)

    def answers() -> tuple[bool, list[str]]:
        naming.at([HOST, ("Arm0", "rtc")])
        naming.providers(HOST)
        texts = [bound.text for bound in naming.tree()]
        return (
            naming.component("Arm0", "rtc") is not None,
            [text for text in texts if not text.startswith("gone.host_cxt/")],
        )

    with ThreadPoolExecutor() as threads:
        assert threads.submit(answers).result(PATIENCE) == (
            True,
            ["gone.host_cxt", "rh3.host_cxt", "rh3.host_cxt/Arm0.rtc"],
        )


@pytest.mark.parametrize("kind", [*NOWHERE, "of another type"])
def test_a_port_takes_the_name_of_what_is_gone(
    kind: str,
    orb: Orb,
    service: tuple[Naming, Any],
    silent: str,
    wrong: Callable[[str], str],
) -> None:
    naming, root = service
    root.bind(named(*PORT), entry(kind, orb, silent, wrong))
    if kind in NOWHERE:
        naming.bind(PORT, "Adder", root)
        assert [*naming.providers(PORT)] == ["Adder"]
    else:
        with pytest.raises(TransportError, match="AlreadyBound"):
            naming.bind(PORT, "Adder", root)


@pytest.mark.parametrize("fault", FAULTS)
def test_a_service_that_answers_wrongly(
    fault: str, orb: Orb, wrong: Callable[[str], str]
) -> None:
    naming = Naming(orb.orb, wrong(fault), orb.limit)
    with ThreadPoolExecutor() as threads:
        for ask in (
            lambda: naming.component("Arm0", "rtc"),
            lambda: naming.at([HOST, ("Arm0", "rtc")]),
            lambda: naming.providers(PORT),
            naming.tree,
        ):
            with suppress(TransportError):
                threads.submit(ask).result(PATIENCE)


def test_contexts_within_each_other_are_entered_to_a_depth(
    service: tuple[Naming, Any],
) -> None:
    naming, root = service
    context = root
    for _ in range(DEPTH):
        context = context.bind_new_context(named("inner"))
    root.bind(named("last"), root)
    texts = [bound.text for bound in naming.tree()]
    assert texts[-1] == "last"
    assert len(texts) < DEPTH
