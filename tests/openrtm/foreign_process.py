"""A process of OpenRTM without rtgen: `foreign_process.py KIND NAMESERVER FORMATS`.

`operator` replaces PositionInput0 of RH3: it sends a goal, and returns FINISH when it is reached.
`mistaken` has a port of another type. `adder` replaces the Counter0 that adds for others.
"""

from __future__ import annotations

import os
import sys
import time
from typing import Any

import OpenRTM_aist
import RTC

# Behind OpenRTM's modules: the own types have a module RTC, too, and add to the imported one.
sys.path.append(os.environ["TYPES"])


def profile(name: str) -> Any:
    """Return the profile of a component."""
    texts = ["implementation_id", name, "type_name", name, "category", "lab"]
    texts += ["description", "not of rtgen", "version", "1", "vendor", "lab"]
    texts += [
        "conf.default.01_x",
        "0",
        "conf.default.01_y",
        "0",
        "conf.default.01_th",
        "0",
    ]
    texts += ["conf.default.input", "none", "exec_cxt.periodic.rate", "50", ""]
    return OpenRTM_aist.Properties(defaults_str=texts)


class PositionInput(OpenRTM_aist.DataFlowComponentBase):  # type: ignore[misc, name-defined]
    """Sends a goal at its activation."""

    def onInitialize(self) -> Any:
        """Add the ports."""
        import IIS

        for name, variable in (("01_x", "x"), ("01_y", "y"), ("01_th", "theta")):
            setattr(self, variable, [0.0])
            self.bindParameter(name, getattr(self, variable), "0")
        now = RTC.Time(0, 0)
        data = RTC.Pose2D(RTC.Point2D(0.0, 0.0), 0.0)
        self.goal = IIS.TimedPose2D(now, [], data, [])
        self.state = RTC.TimedState(now, 0)
        self.out = OpenRTM_aist.OutPort("positon", self.goal)
        self.inp = OpenRTM_aist.InPort("status", self.state)
        self.addOutPort("positon", self.out)
        self.addInPort("status", self.inp)
        return RTC.RTC_OK

    def onActivated(self, ec_id: int) -> Any:
        """Reset the state."""
        self.sent = False
        self.begun = 0.0
        return RTC.RTC_OK

    def onExecute(self, ec_id: int) -> Any:
        """Send the goal once, then wait for its end; after 2 s its activator continues."""
        if self.begun and time.monotonic() > self.begun + 2.0:
            self.begun = 0.0
            print("going", flush=True)
        if not self.sent:
            self.sent = True
            self.begun = time.monotonic()
            position = RTC.Point2D(self.x[0], self.y[0])
            self.goal.data = RTC.Pose2D(position, self.theta[0])
            self.out.write()
            print("sent", flush=True)
        while self.inp.isNew():
            if self.inp.read().data == 0:
                print("FINISH", flush=True)
        return RTC.RTC_OK


class Mistaken(OpenRTM_aist.DataFlowComponentBase):  # type: ignore[misc, name-defined]
    """A component whose ports have other types."""

    def onInitialize(self) -> Any:
        """Add the ports."""
        self.value = RTC.TimedLong(RTC.Time(0, 0), 0)
        self.out = OpenRTM_aist.OutPort("positon", self.value)
        self.inp = OpenRTM_aist.InPort("status", self.value)
        self.addOutPort("positon", self.out)
        self.addInPort("status", self.inp)
        return RTC.RTC_OK


class Counter(OpenRTM_aist.DataFlowComponentBase):  # type: ignore[misc, name-defined]
    """A component that adds while it is active."""

    def onInitialize(self) -> Any:
        """Add the port."""
        import Calc__POA

        class Adder(Calc__POA.Adder):  # type: ignore[misc, name-defined]
            def add(self, a: int, b: int) -> int:
                return a + b

        self.adder = Adder()
        self.port = OpenRTM_aist.CorbaPort("adding")
        # Registered without its scope, as authors of many components do.
        self.port.registerProvider("adder", "Adder", self.adder)
        self.addPort(self.port)
        return RTC.RTC_OK


KINDS = {
    "operator": (PositionInput, "PositionInput"),
    "mistaken": (Mistaken, "PositionInput"),
    "adder": (Counter, "Counter"),
}


def main(kind: str, nameserver: str, formats: str) -> None:
    """Serve a component until the process is ended."""
    made, name = KINDS[kind]
    options = {
        "corba.nameservers": nameserver,
        "corba.endpoints": "127.0.0.1:",
        "logger.enable": "NO",
        "naming.formats": formats,
    }
    settings = [
        text for key, value in options.items() for text in ("-o", f"{key}:{value}")
    ]
    manager = OpenRTM_aist.Manager.init(["foreign", *settings])

    def begin(manager: Any) -> None:
        manager.registerFactory(profile(name), made, OpenRTM_aist.Delete)
        assert manager.createComponent(name) is not None

    manager.setModuleInitProc(begin)
    manager.activateManager()
    print("ready", flush=True)
    manager.runManager()


if __name__ == "__main__":
    main(*sys.argv[1:])
