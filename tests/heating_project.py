"""A project of two components with a service, a system, a timeline, settings and tests."""

from __future__ import annotations

from pathlib import Path

FILES = {
    "rtgen.toml": """\
[sources]
paths = ["idl", "systems"]

[output]
package = "warmth"
skeletons = "src/heating"

[ros2]
topics = { "Heater0.temperature" = "/warm/temperature" }

[ros2.services]
"Heater0.setup.set_room" = "/warm/room"
""",
    "idl/heating.idl": """\
module Heating {
    struct Position { double x; double y; };
    /** A temperature at an instant. */
    struct Temperature { double value; Position place; };
    /** How much a heater gives. */
    struct Power { double watt; };
    exception Refused { string why; };
    enum Level { OFF, WARM };
    interface Setup {
        double set_room(in double celsius) raises (Refused);
        void choose(in Level mode);
    };
};
@rtc(category="Demo", vendor="me", rate=10.0)
component Heater {
    publishes Heating::Temperature temperature;
    consumes Heating::Power power;
    provides Heating::Setup setup;
    @default(0.01) @min(0.0)
    attribute double warming;
};
@rtc(category="Demo", vendor="me", rate=10.0)
component Controller {
    consumes Heating::Temperature temperature;
    publishes Heating::Power power;
    uses Heating::Setup setup;
    @default(60.0)
    attribute double target;
};
""",
    "src/heating/__init__.py": "",
    "src/heating/heater.py": '''\
"""A vessel of water. The names power, value and temperature of comments stay."""

from __future__ import annotations

from rtgen.runtime import RTC_OK, ReturnCode_t
from warmth.components.heater import HeaterBase
from warmth.heating import Level, Position, Power, Refused, Setup, Temperature

ROOM = 20.0


class Settings(Setup):
    """The service of the heater."""

    def __init__(self) -> None:
        self.mode = Level.OFF
        self.room = ROOM

    def set_room(self, celsius: float) -> float:
        if celsius < 0.0:
            raise Refused(why="cold")
        self.room, old = celsius, self.room
        return old

    def choose(self, mode: Level) -> None:
        self.mode = Level.WARM if mode is Level.WARM else Level.OFF


def given(powers: list[Power]) -> float:
    """Return the sum of powers."""
    return sum(power.watt for power in powers)


class Heater(HeaterBase):
    """A vessel of water."""

    def on_initialize(self) -> ReturnCode_t:
        self.settings = Settings()
        self.setup.set_servant(self.settings)
        self.value = 3
        return RTC_OK

    def on_activated(self, ec_id: int) -> ReturnCode_t:
        self.celsius = ROOM
        self.watt = 0.0
        return RTC_OK

    def on_execute(self, ec_id: int) -> ReturnCode_t:
        power = self.power.read_newest()
        if power is not None:
            self.watt = given([power])
        cooling = 0.005 * (self.celsius - self.settings.room)
        self.celsius += 0.1 * (self.config.warming * self.watt - cooling)
        temperature = Temperature(value=self.celsius, place=Position(1.0, y=2.0))
        assert temperature.place.y == 2.0
        self.temperature.write(temperature)
        return RTC_OK
''',
    "src/heating/controller.py": '''\
"""Keeps a temperature."""

from __future__ import annotations

import warmth.heating as types
from rtgen.runtime import RTC_OK, ReturnCode_t
from warmth.components.controller import ControllerBase


class Controller(ControllerBase):
    """Keeps a temperature."""

    def on_execute(self, ec_id: int) -> ReturnCode_t:
        measured = self.temperature.read_newest()
        if measured is not None:
            cold = measured.value < self.config.target
            self.power.write(types.Power(watt=100.0 if cold else 0.0))
            self.setup.choose(types.Level.WARM)
            self.setup.set_room(celsius=20.0)
        return RTC_OK
''',
    "tests/test_heating.py": '''\
"""The heater, and the system."""

from __future__ import annotations

from pathlib import Path

import pytest
from heating.controller import Controller
from heating.heater import Heater, Settings
from rtgen.cli import run
from rtgen.runtime import SECOND, SimulatedClock, System
from warmth.heating import Power, Refused

ROOT = Path(__file__).parents[1]


def test_the_heater_warms() -> None:
    heater, controller = Heater("Heater0"), Controller("C")
    with System(SimulatedClock()) as system:
        system.add(heater, 10.0)
        system.add(controller, 10.0)
        system.connect(("C", "power"), ("Heater0", "power"))
        system.connect(("Heater0", "temperature"), ("C", "temperature"))
        system.configure("Heater0", "warming", "0.5")
        system.activate("Heater0")
        controller.power.write(Power(watt=10.0))
        system.run(until_ns=SECOND)
        measured = controller.temperature.read_newest()
        assert measured is not None
        assert measured.value > 20.0
        assert measured.place.x == 1.0


def test_a_cold_room_is_refused() -> None:
    settings = Settings()
    assert settings.set_room(5.0) == 20.0
    with pytest.raises(Refused) as refused:
        settings.set_room(-1.0)
    assert refused.value.why == "cold"


def test_the_system_runs(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    monkeypatch.chdir(ROOT)
    values = tmp_path / "values.csv"
    command = ["run", "systems/warm", "--until", "5", "--set", "Heater0.warming=0.1"]
    assert run([*command, "--csv", "Heater0.temperature.value", "--csv", str(values)]) == 0
    assert "Heater0.temperature.value" in values.read_text()
''',
    "systems/warm/system.xml": """\
<?xml version="1.0" encoding="UTF-8"?>
<rts:RtsProfile rts:id="RTSystem:me:warm:1.0.0" rts:version="0.2" rts:abstract="Heater and power"
    xmlns:rts="http://www.openrtp.org/namespaces/rts"
    xmlns:rtsExt="http://www.openrtp.org/namespaces/rts_ext"
    xmlns:xsi="http://www.w3.org/2001/XMLSchema-instance">
  <!-- Heater0.temperature -->
  <rts:Components rts:id="RTC:me:Demo:Heater:1.0.0" rts:instanceName="Heater0"
      rts:pathUri="localhost/Heater0.rtc" rts:compositeType="None" rts:isRequired="true"
      rts:activeConfigurationSet="default">
    <rts:DataPorts rts:name="Heater0.temperature"/>
    <rts:DataPorts rts:name="Heater0.power"/>
    <rts:ServicePorts rts:name="Heater0.setup"/>
    <rts:ConfigurationSets rts:id="default">
      <rts:ConfigurationData rts:name="warming" rts:data="0.02"/>
    </rts:ConfigurationSets>
    <rts:ConfigurationSets rts:id="slow">
      <rts:ConfigurationData rts:name="warming" rts:data="0.01"/>
    </rts:ConfigurationSets>
  </rts:Components>
  <rts:Components rts:id="RTC:me:Demo:Controller:1.0.0" rts:instanceName="Controller0"
      rts:pathUri="localhost/Controller0.rtc" rts:compositeType="None" rts:isRequired="true"
      rts:activeConfigurationSet="tea">
    <rts:DataPorts rts:name="Controller0.temperature"/>
    <rts:DataPorts rts:name="Controller0.power"/>
    <rts:ServicePorts rts:name="Controller0.setup"/>
    <rts:ConfigurationSets rts:id="tea">
      <rts:ConfigurationData rts:name="target" rts:data="80.0"/>
    </rts:ConfigurationSets>
  </rts:Components>
  <rts:DataPortConnectors rts:connectorId="measured" rts:name="measured"
      rts:dataType="IDL:Heating/Temperature:1.0" rts:interfaceType="corba_cdr"
      rts:dataflowType="push" rts:subscriptionType="flush">
    <rts:sourceDataPort rts:portName="Heater0.temperature" rts:instanceName="Heater0"
        rts:componentId="RTC:me:Demo:Heater:1.0.0"/>
    <rts:targetDataPort rts:portName="Controller0.temperature" rts:instanceName="Controller0"
        rts:componentId="RTC:me:Demo:Controller:1.0.0"/>
  </rts:DataPortConnectors>
  <rts:DataPortConnectors rts:connectorId="heating" rts:name="heating"
      rts:dataType="IDL:Heating/Power:1.0" rts:interfaceType="corba_cdr"
      rts:dataflowType="push" rts:subscriptionType="flush">
    <rts:sourceDataPort rts:portName="Controller0.power" rts:instanceName="Controller0"
        rts:componentId="RTC:me:Demo:Controller:1.0.0"/>
    <rts:targetDataPort rts:portName="power" rts:instanceName="Heater0"
        rts:componentId="RTC:me:Demo:Heater:1.0.0"/>
  </rts:DataPortConnectors>
  <rts:ServicePortConnectors rts:connectorId="setup" rts:name="setup">
    <rts:sourceServicePort rts:portName="Controller0.setup" rts:instanceName="Controller0"
        rts:componentId="RTC:me:Demo:Controller:1.0.0"/>
    <rts:targetServicePort rts:portName="Heater0.setup" rts:instanceName="Heater0"
        rts:componentId="RTC:me:Demo:Heater:1.0.0"/>
  </rts:ServicePortConnectors>
  <rts:Activation>
    <rts:targets rts:sequence="1">
      <rts:TargetComponent rts:componentId="RTC:me:Demo:Heater:1.0.0"
          rts:instanceName="Heater0" rts:id="0"/>
    </rts:targets>
    <rts:targets rts:sequence="2">
      <rts:TargetComponent rts:componentId="RTC:me:Demo:Controller:1.0.0"
          rts:instanceName="Controller0" rts:id="0"/>
    </rts:targets>
  </rts:Activation>
</rts:RtsProfile>
""",
    "systems/warm/timeline.toml": """\
# Heater0.temperature is cut for a second.

[[at]]
t = 2.0
disconnect = { from = "Heater0.temperature", to = "Controller0.temperature" }
set = { Heater0.warming = 0.01, Controller0.target = 50.0 }

[[at]]
t = 3.0
connect = { from = "Heater0.temperature", to = "Controller0.temperature" }
set = ["Heater0.warming=0.02", "Controller0.target=60"]

[[at]]
t = 3.5
set = { "Heater0.warming" = 0.03 }

[[at]]
t = 4.0

[at.set.Heater0]
warming = 0.04
""",
    "systems/warm/Heater.conf": "conf.default.warming: 0.05\nconf.slow.warming: 0.04\n",
    "systems/rtc.conf": """\
# Heater and Controller
manager.components.precreate: Heater, Controller
manager.components.preconnect: Heater0.temperature?port=Controller0.temperature
manager.components.preactivation: Heater0, Controller0
Demo.Heater.config_file: warm/Heater.conf
""",
    "systems/second.xml": """\
<?xml version="1.0" encoding="UTF-8"?>
<rts:RtsProfile rts:id="RTSystem:me:second:1.0.0" rts:version="0.2"
    xmlns:rts="http://www.openrtp.org/namespaces/rts">
  <rts:Components rts:id="RTC:me:Demo:Heater:1.0.0" rts:instanceName="Oven"
      rts:pathUri="localhost/Oven.rtc" rts:compositeType="None" rts:isRequired="true"
      rts:activeConfigurationSet="default">
    <rts:DataPorts rts:name="Oven.temperature"/>
  </rts:Components>
</rts:RtsProfile>
""",
}
"""The files of the project by their names."""


def write(folder: Path) -> None:
    """Write the project."""
    for name, text in FILES.items():
        file = folder / name
        file.parent.mkdir(parents=True, exist_ok=True)
        file.write_text(text, encoding="utf-8")


def texts(folder: Path) -> dict[str, str]:
    """Return the texts of the project's files, without generated ones."""
    return {
        path.relative_to(folder).as_posix(): path.read_text(encoding="utf-8")
        for path in sorted(folder.rglob("*"))
        if path.is_file()
        and path.relative_to(folder).parts[0]
        in ("idl", "src", "systems", "tests", "rtgen.toml")
        and "__pycache__" not in path.parts
    }
