"""The names of an interface's type over CORBA."""

from __future__ import annotations

from pathlib import Path

import pytest

from refrobots.canopen import Manager
from rtgen.cli import run
from rtgen.runtime import Component, ComponentProfile, service_port
from rtgen.runtime.corba.rt_objects.services import descriptor, offers, type_names


class Peer(Component):
    profile = ComponentProfile(
        "Peer",
        ports=(
            service_port("provider", "own", Manager, type_name="Lab::Boss"),
            service_port("consumer", "other", Manager),
        ),
    )


def test_the_author_s_name_goes_before_the_scoped_one() -> None:
    peer = Peer("Peer0")
    provider = peer.add_provider("own", "own", Manager)
    consumer = peer.add_consumer("other", "other", Manager)
    assert type_names(provider) == ["Lab::Boss", "CANopen::Manager", "Manager"]
    assert type_names(consumer) == ["CANopen::Manager", "Manager"]
    assert descriptor(provider) == "Lab::Boss.own"
    assert descriptor(consumer) == "CANopen::Manager.other"
    assert offers("Peer0", "own", {provider: "IOR:1"}) == dict.fromkeys(
        (
            "Peer0.port.own.provided.Lab::Boss.own",
            "port.Lab::Boss.own",
            "port.CANopen::Manager.own",
            "port.Manager.own",
        ),
        "IOR:1",
    )


def test_the_annotation_is_in_the_generated_profile(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    Path("a.idl").write_text(
        "interface Echo { void say(); };\n"
        'component Shy { @type_name("Boss") provides Echo own; uses Echo other; };\n'
    )
    assert run(["generate", "a.idl", "-o", "out", "-q"]) == 0
    [base] = Path("out/generated").glob("*/components/shy/__init__.py")
    assert base.read_text().count('type_name="Boss"') == 1
