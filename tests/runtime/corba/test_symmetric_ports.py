"""Symmetric service ports: each provides what the other one requires, under one name."""

from __future__ import annotations

import importlib
import sys
from collections.abc import Iterator
from contextlib import ExitStack, closing
from pathlib import Path
from typing import Any

import pytest

pytest.importorskip("omniORB", reason="omniORBpy is not installed")

from rtgen.cli import run as rtgen
from rtgen.runtime import RTC_OK, RealClock, System
from rtgen.runtime.corba.naming import Naming
from rtgen.runtime.corba.orb import Orb
from rtgen.runtime.corba.rt_objects.foreign import located
from rtgen.runtime.corba.rt_objects.objects import Exported
from rtgen.runtime.corba.rt_objects.remote import RemoteRtc
from rtgen.runtime.corba.rt_objects.wire import ConnectorProfile, values
from rtgen.runtime.corba.transport import NamedCorba

IDL = """module Ward { interface Phone { string name(); }; };
component Room {
  @port("line") provides Ward::Phone own;
  @port("line") uses Ward::Phone other;
};
"""
SETTINGS = """[sources]
paths = ["ward.idl"]
[output]
package = "wardbot"
skeletons = "src/wardnodes"
"""


@pytest.fixture
def rooms(
    tmp_path: Path, names: str, monkeypatch: pytest.MonkeyPatch
) -> Iterator[list[Any]]:
    """Yield two components, each in a system with a transport of its own."""
    (tmp_path / "ward.idl").write_text(IDL)
    (tmp_path / "rtgen.toml").write_text(SETTINGS)
    monkeypatch.chdir(tmp_path)
    assert rtgen(["generate", "-q"]) == 0
    monkeypatch.syspath_prepend(str(tmp_path / "generated"))
    importlib.invalidate_caches()
    module = importlib.import_module("wardbot.components.room")
    ward = importlib.import_module("wardbot.ward")

    class Phone(ward.Phone):  # type: ignore[misc, name-defined]
        def __init__(self, name: str) -> None:
            self._name = name

        def name(self) -> str:
            return self._name

    class Room(module.RoomBase):  # type: ignore[misc, name-defined]
        def on_initialize(self) -> Any:
            self.own.set_servant(Phone(self.instance_name))
            return RTC_OK

    made = []
    with ExitStack() as stack:
        for name in ("Room1", "Room2"):
            transport = stack.enter_context(NamedCorba(name_server=names))
            system = stack.enter_context(System(RealClock(), transport))
            made.append(Room(name))
            system.add(made[-1], 100.0)
            system.activate(name)
            system.run(until_ns=50_000_000)
        yield made
    for name in [each for each in sys.modules if each.startswith("wardbot")]:
        del sys.modules[name]


@pytest.mark.parametrize("strictness", ["strict", "best_effort"])
def test_each_calls_the_other_one(
    rooms: list[Any], names: str, strictness: str
) -> None:
    with closing(Orb()) as orb:
        exported = Exported(orb)
        ends = []
        for room in rooms:
            place = f"{names}/{room.instance_name}.rtc"
            found = located(place, exported, lambda host: Naming(orb.orb, host))
            rtc = RemoteRtc(found, exported)
            [port] = rtc.call("get_component_profile").port_profiles
            ends.append((rtc, port))
        asked = ConnectorProfile(
            "line",
            "line",
            [port.port_ref for _, port in ends],
            values({"port.connection.strictness": strictness}),
        )
        code, _ = ends[0][0].at_port(ends[0][1], "connect", asked)
        assert code is RTC_OK
        assert [room.other.object.name() for room in rooms] == ["Room2", "Room1"]
        assert ends[0][0].at_port(ends[0][1], "disconnect", "line") is RTC_OK
