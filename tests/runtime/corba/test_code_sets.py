"""Texts for a process whose code set does not have their characters."""

from __future__ import annotations

import subprocess
import sys
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

import pytest

pytest.importorskip("omniORB", reason="omniORBpy is not installed")
sys.path.append(str(Path(__file__).parents[2] / "compiler" / "types"))

import emitted
from code_set_peer import IDL
from omniORB import any as anys

from rtgen.runtime.corba.objects import Objects
from rtgen.runtime.corba.orb import Orb
from rtgen.runtime.corba.rt_objects.objects import CallError, Exported
from rtgen.runtime.corba.rt_objects.wire import (
    CONFIGURATION,
    ConfigurationSet,
    NameValue,
)
from rtgen.runtime.services.servants import MarshalError

REMEDY = "start it with -ORBnativeCharCodeSet UTF-8 (OpenRTM: corba.args in rtc.conf)"

Peer = tuple[Any, Any]
"""The references of a configuration and of a service."""


@pytest.fixture(scope="module")
def orb() -> Iterator[Orb]:
    made = Orb(timeout=20.0)
    yield made
    made.close()


@pytest.fixture(scope="module")
def peer(orb: Orb) -> Iterator[Callable[[str], Peer]]:
    """Yield a function that starts a process with a code set."""
    script = str(Path(__file__).with_name("code_set_peer.py"))
    processes: list[subprocess.Popen[str]] = []
    found: dict[str, Peer] = {}

    def started(code_set: str) -> Peer:
        if code_set not in found:
            process = subprocess.Popen(
                [sys.executable, script, code_set],
                stdin=subprocess.PIPE,
                stdout=subprocess.PIPE,
                text=True,
            )
            processes.append(process)
            assert process.stdout is not None
            first, second = (process.stdout.readline().strip() for _ in range(2))
            found[code_set] = (
                orb.orb.string_to_object(first),
                orb.orb.string_to_object(second),
            )
        return found[code_set]

    yield started
    for process in processes:
        process.communicate()


def set_label(orb: Orb, reference: Any, text: str) -> Any:
    given = ConfigurationSet("default", "", [NameValue("label", anys.to_any(text))])
    call = "set_configuration_set_values", given
    return Exported(orb).call(reference, CONFIGURATION, *call)


SETS = [
    ("-", "日本", "日", "ISO 8859-1"),
    ("-", "aé€", "€", "ISO 8859-1"),
]


@pytest.mark.parametrize(("code_set", "text", "character", "name"), SETS)
def test_a_parameter(
    orb: Orb,
    peer: Callable[[str], Peer],
    code_set: str,
    text: str,
    character: str,
    name: str,
) -> None:
    reference, _ = peer(code_set)
    with pytest.raises(CallError) as caught:
        set_label(orb, reference, text)
    assert str(caught.value) == (
        f"{text!r} has {character!r}, and the other process has the code set {name}; {REMEDY}"
    )
    assert set_label(orb, reference, "aé") is True


@pytest.mark.parametrize(("code_set", "text", "character", "name"), SETS)
def test_an_argument_of_a_service(
    orb: Orb,
    peer: Callable[[str], Peer],
    tmp_path: Path,
    code_set: str,
    text: str,
    character: str,
    name: str,
) -> None:
    _, reference = peer(code_set)
    package = emitted.emit_text(tmp_path, IDL).noting
    notes = Objects(orb).stub(package.Notes, reference)
    with pytest.raises(MarshalError) as caught:
        notes.keep(package.Note("a", ["b", text]))
    assert str(caught.value) == (
        f"keep: {text!r} has {character!r}, and the other process has the code set {name}; "
        f"{REMEDY}"
    )
    assert notes.keep(package.Note("aé", [])) == "aé"


@pytest.mark.sampled(0)
def test_utf_8_has_all(orb: Orb, peer: Callable[[str], Peer], tmp_path: Path) -> None:
    reference, other = peer("UTF-8")
    assert set_label(orb, reference, "日本 €") is True
    package = emitted.emit_text(tmp_path, IDL).noting
    notes = Objects(orb).stub(package.Notes, other)
    assert notes.keep(package.Note("日本 €", [])) == "日本 €"
