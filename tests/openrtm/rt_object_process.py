"""A process with a system of two components over CORBA: `rt_object_process.py NAMESERVER FOLDER`.

omniORB copies arguments within a process by the caller's stubs, so stubs of OpenRTM and components
of rtgen need two processes. Each line of the input is an expression about `system`, `ours` and
`long`; the answer is a line with its value.
"""

from __future__ import annotations

import os
import sys
import threading
from collections.abc import Callable
from pathlib import Path
from types import ModuleType
from typing import Any

sys.path.append(str(Path(__file__).parents[1] / "compiler" / "types"))

import emitted

from rtgen.compiler.kit.resources import idl_file
from rtgen.runtime import (
    RTC_ERROR,
    RTC_OK,
    Component,
    ComponentProfile,
    ParameterProfile,
    RealClock,
    ReturnCode_t,
    System,
)
from rtgen.runtime.corba.transport import NamedCorba
from rtgen.runtime.errors import RtcError


class Values:
    """Parameters."""

    def __init__(self) -> None:
        self.gain = 2.0


def made(package: ModuleType, instance: str) -> Any:
    """Return a component with a port of each kind, which echoes its input."""
    long, echo = package.rtc.TimedLong, package.facts.Echo

    class Said(echo):  # type: ignore[misc, valid-type]
        def say(self, text: str) -> str:
            if text == "refused":
                raise package.facts.Refused("no")
            return text * 2

    class Ours(Component):
        profile = ComponentProfile(
            "Ours",
            category="tests",
            vendor="labs",
            configuration=(ParameterProfile("gain", "gain", "double", "2.0"),),
        )

        def __init__(self) -> None:
            super().__init__(instance)
            self.inp = self.add_in_port("data", long)
            self.out = self.add_out_port(".positon", long)
            self.echo = self.add_provider("said", "echo", echo)
            self.asked = self.add_consumer("asking", "echo", echo)
            self.values = self.add_configuration(Values())
            self.got: list[int] = []
            self.fails = False

        def on_initialize(self) -> ReturnCode_t:
            self.echo.set_servant(Said())
            return RTC_OK

        def on_execute(self, ec_id: int) -> ReturnCode_t:
            while self.inp.is_new():
                sample = self.inp.read()
                assert sample is not None
                self.got.append(sample.data)
            return RTC_ERROR if self.fails else RTC_OK

    return Ours()


def refused(action: Callable[..., object], *arguments: Any) -> str:
    """Return the error of an action; empty if it has none."""
    try:
        action(*arguments)
    except RtcError as error:
        return f"{type(error).__name__}: {error}"
    return ""


def main(naming_service: str, folder: str) -> None:
    """Serve `Ours0` and `Other0` until the input ends."""
    facts = Path(__file__).with_name("facts.idl")
    package = emitted.emit(Path(folder), [facts, idl_file("BasicDataType.idl")])
    with (
        NamedCorba(name_server=naming_service) as transport,
        System(RealClock(), transport) as system,
    ):
        ours = made(package, "Ours0")
        for component in (ours, made(package, "Other0")):
            system.add(component, 200.0)
        names = {
            "system": system,
            "transport": transport,
            "ours": ours,
            "long": package.rtc.TimedLong,
            "refused": refused,
        }
        ended = threading.Event()

        def answer() -> None:
            for line in sys.stdin:
                print(repr(eval(line, names)), flush=True)
            ended.set()

        threading.Thread(target=answer).start()
        print("ready", flush=True)
        system.run(until=lambda _: ended.is_set())


if __name__ == "__main__":
    main(*sys.argv[1:])
    # Threads of omniORB that end together with the interpreter may abort the process.
    os._exit(0)
