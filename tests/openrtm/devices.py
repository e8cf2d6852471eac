"""A system with two devices in C++ that rtgen does not run, and a component that drives them."""

from __future__ import annotations

import os
import re
import signal
import sys
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from pathlib import Path

import middleware
from logged_process import LoggedProcess

from rtgen.cli import run as rtgen

SETTINGS = """\
[sources]
paths = ["pilot.idl"]
include = ["{types}"]

[output]
package = "piloted"

[components]
Pilot = "pilot:Pilot"
"""
IDL = """\
#include "BasicDataType.idl"

@rtc(category="Lab", vendor="lab", rate=50.0)
component Pilot {
    publishes RTC::TimedDoubleSeq base;
    publishes RTC::TimedDoubleSeq arm;
    consumes RTC::TimedDoubleSeq seen;
    @default("") attribute string fault;
    @default(0) attribute long size;
};
"""
PILOT = '''\
"""Sends commands; fails on demand."""

import os
import time

from piloted.components.pilot import PilotBase
from piloted.rtc import TimedDoubleSeq
from rtgen.runtime import RTC_OK


class Pilot(PilotBase):
    def on_activated(self, ec_id):
        self.ticks = self.received = 0
        print(f"pilot activated at {time.monotonic()} in process {os.getpid()}", flush=True)
        return RTC_OK

    def on_execute(self, ec_id):
        self.ticks += 1
        if self.ticks == 10:
            self.fail()
        size = self.config.size if self.ticks == 20 and self.config.size else 3
        self.base.write(TimedDoubleSeq(data=[1.0] * size))
        self.arm.write(TimedDoubleSeq(data=[1.0] * 3))
        while self.seen.is_new():
            self.seen.read()
            self.received += 1
        return RTC_OK

    def on_deactivated(self, ec_id):
        print(f"pilot deactivated at {time.monotonic()}, received {self.received}", flush=True)
        if self.config.fault == "hang":
            while True:
                try:
                    time.sleep(60)
                except KeyboardInterrupt:
                    print("goes on", flush=True)
        return RTC_OK

    def fail(self):
        if self.config.fault == "raise":
            raise ValueError("broken")
        if self.config.fault == "end":
            raise KeyboardInterrupt
        if self.config.fault == "exit":
            raise SystemExit(5)
'''
_COMPONENT = """\
  <rts:Components rts:id="RTC:lab:Lab:{type}:1.0.0" rts:instanceName="{instance}"
      rts:pathUri="localhost/{instance}.rtc" rts:compositeType="None" rts:isRequired="true"
      rts:activeConfigurationSet="default">
{ports}{values}  </rts:Components>
"""
_CONNECTION = """\
  <rts:DataPortConnectors rts:connectorId="{name}" rts:name="{name}"
      rts:dataType="IDL:RTC/TimedDoubleSeq:1.0" rts:interfaceType="corba_cdr"
      rts:dataflowType="push" rts:subscriptionType="flush">
    <rts:sourceDataPort rts:portName="{source}" rts:instanceName="{first}"
        rts:componentId="{from_id}"/>
    <rts:targetDataPort rts:portName="{target}" rts:instanceName="{second}"
        rts:componentId="{to_id}"/>
  </rts:DataPortConnectors>
"""
_ACTIVATION = """\
    <rts:targets xsi:type="rtsExt:condition_ext" rts:sequence="{number}">
      <rts:WaitTime rts:waitTime="0"/>
      <rts:TargetComponent rts:componentId="{id}" rts:instanceName="{instance}" rts:id="0"/>
    </rts:targets>
"""
DEVICE_PORTS = ("command", "measured")
PORTS = {
    "Base0": DEVICE_PORTS,
    "Pilot0": ("base", "arm", "seen"),
    "Arm0": DEVICE_PORTS,
}
"""The components, in the order of their activation."""
CONNECTIONS = {
    "to_base": ("Pilot0.base", "Base0.command"),
    "to_arm": ("Pilot0.arm", "Arm0.command"),
    "from_base": ("Base0.measured", "Pilot0.seen"),
}


def _id(instance: str) -> str:
    type_ = "Pilot" if instance == "Pilot0" else "Device"
    return f"RTC:lab:Lab:{type_}:1.0.0"


def system(
    values: dict[str, dict[str, str]] | None = None,
    connections: dict[str, tuple[str, str]] | None = None,
) -> str:
    """Return the system, with values of parameters by instance."""
    components = [
        _COMPONENT.format(
            type=_id(instance).split(":")[3],
            instance=instance,
            ports="".join(
                f'    <rts:DataPorts rts:name="{instance}.{port}"/>\n' for port in ports
            ),
            values="".join(_sets((values or {}).get(instance, {}))),
        )
        for instance, ports in PORTS.items()
    ]
    made = [
        _CONNECTION.format(
            name=name,
            source=source,
            target=target,
            first=(first := source.partition(".")[0]),
            second=(second := target.partition(".")[0]),
            from_id=_id(first),
            to_id=_id(second),
        )
        for name, (source, target) in (connections or CONNECTIONS).items()
    ]
    activation = [
        _ACTIVATION.format(number=number, id=_id(instance), instance=instance)
        for number, instance in enumerate(PORTS, 1)
    ]
    return (
        '<?xml version="1.0" encoding="UTF-8"?>\n'
        '<rts:RtsProfile rts:id="RTSystem:lab:piloted:1.0.0" rts:version="0.2"\n'
        '    xmlns:rts="http://www.openrtp.org/namespaces/rts"\n'
        '    xmlns:rtsExt="http://www.openrtp.org/namespaces/rts_ext"\n'
        '    xmlns:xsi="http://www.w3.org/2001/XMLSchema-instance">\n'
        f"{''.join(components)}{''.join(made)}"
        f"  <rts:Activation>\n{''.join(activation)}  </rts:Activation>\n"
        '  <rtsExt:Properties rtsExt:name="rtgen.foreign" rtsExt:value="Base0, Arm0"/>\n'
        "</rts:RtsProfile>\n"
    )


def _sets(values: dict[str, str]) -> Iterator[str]:
    if values:
        yield '    <rts:ConfigurationSets rts:id="default">\n'
        for name, text in values.items():
            yield f'      <rts:ConfigurationData rts:name="{name}" rts:data="{text}"/>\n'
        yield "    </rts:ConfigurationSets>\n"


def project(folder: Path) -> Path:
    """Write the project of the component Pilot, generated, and the system."""
    (folder / "rtgen.toml").write_text(SETTINGS.format(types=middleware.DATA_TYPES))
    (folder / "pilot.idl").write_text(IDL)
    (folder / "src").mkdir()
    (folder / "src/pilot.py").write_text(PILOT)
    (folder / "system.xml").write_text(system())
    before = Path.cwd()
    os.chdir(folder)
    try:
        assert rtgen(["generate", "-q"]) == 0
    finally:
        os.chdir(before)
    return folder


class Processes:
    """Processes of a test: devices, and those of `rtgen`."""

    def __init__(self, folder: Path, logs: Path, programs: Path, names: str) -> None:
        self.folder = folder
        self.names = names
        self.types = str(middleware.DATA_TYPES)
        self._logs = logs
        self._programs = programs
        self._made: list[LoggedProcess] = []

    def device(self, instance: str, *options: str) -> LoggedProcess:
        """Start a device, and wait until it is bound."""
        place = f"corbaname::{self.names}#{instance}.rtc"
        words = [place, f"instance={instance}", *options]
        words += ["-ORBendPoint", "giop:tcp:127.0.0.1:"]
        made = self._started(words, str(self._programs / "device"))
        made.says("ready")
        return made

    def rtgen(self, command: str, *arguments: str) -> LoggedProcess:
        """Start a command of rtgen."""
        return self._started(["-m", "rtgen", command, *arguments], sys.executable)

    def run(self, *arguments: str, system: str = "system.xml") -> LoggedProcess:
        """Start a run of the system."""
        words = [system, "--clock", "real", "--transport", "corba"]
        return self.rtgen("run", *words, "--nameserver", self.names, *arguments)

    def _started(self, words: Sequence[str], program: str) -> LoggedProcess:
        path = os.pathsep.join(str(self.folder / each) for each in ("src", "generated"))
        environment = {**os.environ, "PYTHONPATH": path}
        log = self._logs / f"{len(self._made)}.txt"
        made = LoggedProcess(words, self.folder, environment, log, program)
        self._made.append(made)
        return made

    def end(self) -> None:
        """Kill those that still run."""
        for each in self._made:
            if each.runs:
                each.process.send_signal(signal.SIGCONT)
                each.end(signal.SIGKILL)


@contextmanager
def processes(
    folder: Path, logs: Path, programs: Path, names: str
) -> Iterator[Processes]:
    """Yield the processes of a test, which end with it."""
    made = Processes(folder, logs, programs, names)
    try:
        yield made
    finally:
        made.end()


def instants(text: str, what: str) -> list[float]:
    """Return the times of an output, by the monotonic clock of the machine [s]."""
    return [float(found) for found in re.findall(rf"{what} at (\d+\.\d+)", text)]
