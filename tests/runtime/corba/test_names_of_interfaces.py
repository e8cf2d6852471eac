"""The names of an interface's type over CORBA."""

from __future__ import annotations

from pathlib import Path

import pytest

from refrobots.canopen import Manager
from rtgen.cli import run
from rtgen.runtime import Component, consumer, provider
from rtgen.runtime.corba.rt_objects.services import descriptor, offers, type_names


class Peer(Component, type_name="Peer"):
    own = provider(Manager, type_name="Lab::Boss")
    other = consumer(Manager)


def test_the_author_s_name_goes_before_the_scoped_one() -> None:
    peer = Peer("Peer0")
    assert type_names(peer.own) == ["Lab::Boss", "CANopen::Manager", "Manager"]
    assert type_names(peer.other) == ["CANopen::Manager", "Manager"]
    assert descriptor(peer.own) == "Lab::Boss.own"
    assert descriptor(peer.other) == "CANopen::Manager.other"
    assert offers("Peer0", "own", {peer.own: "IOR:1"}) == dict.fromkeys(
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
