"""A component with everything, generated for OpenRTM, and its behaviour for inspection by tests."""

from __future__ import annotations

import importlib
import os
import subprocess
import sys
from pathlib import Path
from types import ModuleType
from typing import Any

import middleware
from openrtm_lab import Lab

from rtgen.cli import run

SETTINGS = """
[sources]
paths = ["idl"]
include = ["stock"]

[output]
target = "openrtm"
package = "hosted"
skeletons = "src/behaviours_hosted"
"""

TYPES = """
#include "BasicDataType.idl"
module Hosted {
    enum Mode { SLOW, FAST };
    struct Sample {
        RTC::Time tm; long number; string text; char letter; sequence<octet> raw; Mode speed;
    };
    exception Refused { string why; };
    interface Counter {
        long add(in long amount) raises (Refused);
        attribute long total;
    };
};
// OpenRTM's own module, opened again; and what stands in no module.
module RTC {
    struct TimedWheel { Time tm; sequence<double> angles; };
};
struct Plain { wstring text; };
interface Bell { string ring(in Plain how); };
"""

COMPONENT = """
#include "hosted_types.idl"
/** Passes samples on. */
@rtc(category="Tests", vendor="rtgen", version="1.2.0", description="Relay, 中継", rate=50.0)
component Relay {
    consumes Hosted::Sample data;
    @name("data") publishes Hosted::Sample data_out;
    @name(".positon") publishes RTC::TimedLong positon;
    @port("counting") provides Hosted::Counter counter;
    @port("asking") @instance("Counter") uses Hosted::Counter other;
    consumes RTC::TimedWheel wheel;
    publishes Plain plain;
    @port("bells") @type_name("lab::Ringer") provides Bell bell;
    @unit("m") @default(2.0) @min(0.0) @max(10.0) @widget("slider.0.1") attribute double gain;
    @default(TRUE) attribute boolean on;
    attribute string note;
    @default(5) @constraint("0<=x<=9") attribute long level;
    @default("0.1, 0.2") attribute sequence<double> gains;
    attribute sequence<long> nothing;
    attribute Hosted::Mode speed;
    // OpenRTM's components have a member of this name of their own.
    @default("x") attribute string properties;
};
"""

BEHAVIOUR = '''
from hosted.components.relay import RelayBase
from hosted import Bell
from hosted.hosted import Counter, Refused
from rtgen.runtime import RTC_ERROR, RTC_OK


class CounterServant(Counter):
    total = 0

    def add(self, amount):
        if amount < 0:
            raise Refused("negative")
        if amount > 1000:
            raise RuntimeError("too much")
        self.total += amount
        return self.total


class BellServant(Bell):
    def ring(self, how):
        return how.text[::-1]


class Relay(RelayBase):
    """Notes its callbacks; `answers` has what they do other than to return RTC_OK."""

    def __init__(self, instance_name=None):
        super().__init__(instance_name)
        self.calls = []
        self.answers = {}

    def _noted(self, name, *arguments):
        self.calls.append((name, *arguments))
        answer = self.answers.get(name, RTC_OK)
        return answer() if callable(answer) else answer

    def on_initialize(self):
        self.counter.set_servant(CounterServant())
        self.bell.set_servant(BellServant())
        return self._noted("on_initialize")

    def on_finalize(self):
        return self._noted("on_finalize")


def _callback(name):
    def callback(self, ec_id):
        return self._noted(name, ec_id)

    return callback


for _name in (
    *("on_startup", "on_shutdown", "on_activated", "on_deactivated", "on_aborting"),
    *("on_error", "on_reset", "on_execute", "on_state_update", "on_rate_changed"),
):
    setattr(Relay, _name, _callback(_name))
'''


def generate(folder: Path) -> Path:
    """Generate the project in an empty folder; return the folder of the component."""
    for name, text in (
        ("rtgen.toml", SETTINGS),
        ("idl/hosted_types.idl", TYPES),
        ("idl/relay.idl", COMPONENT),
        ("src/behaviours_hosted/relay.py", BEHAVIOUR),
    ):
        path = folder / name
        path.parent.mkdir(parents=True, exist_ok=True)
        path.write_text(text, encoding="utf-8")
    (folder / "stock").symlink_to(middleware.DATA_TYPES)
    before = Path.cwd()
    os.chdir(folder)
    try:
        assert run(["generate", "-q"]) == 0
    finally:
        os.chdir(before)
    return folder / "generated/openrtm/Relay"


def compile_stubs(component: Path, rtm_folders: list[Path]) -> None:
    """Run the component's script."""
    programs = os.pathsep.join([str(Path(sys.executable).parent), os.environ["PATH"]])
    environment = {
        **middleware.environment(rtm_folders),
        "PYTHON": sys.executable,
        "PATH": programs,
    }
    if not middleware.REAL:
        environment["RTM_IDL"] = str(rtm_folders[-1])
    subprocess.run(
        ["sh", str(component / "idlcompile.sh")], check=True, env=environment
    )


def load(component: Path) -> ModuleType:
    """Import the component's module, as a manager does."""
    sys.path.append(str(component))
    return importlib.import_module(component.name)


class Relay:
    """A running component: OpenRTM's and its behaviour."""

    def __init__(self, component: Any, lab: Lab) -> None:
        assert component is not None
        self.rtc = component
        self.behaviour = component._host.behaviour
        self.lab = lab
        # Attributes that a lab reads to find the effects of a tick.
        component.calls = self.behaviour.calls

    @property
    def calls(self) -> list[str]:
        """The callbacks of the behaviour so far."""
        return [call[0] for call in self.behaviour.calls]

    @property
    def state(self) -> str:
        """OpenRTM's state of the component."""
        return str(self.lab.state(self.rtc))

    def answer(self, callback: str, answer: Any) -> None:
        """Set the answer of a callback: a value to return, or a function to call."""
        self.behaviour.answers[callback] = answer

    def tick(self) -> list[str]:
        """Return the callbacks of one cycle."""
        return [call[0] for call in self.lab.tick(self.rtc)]

    def activate(self) -> None:
        """Activate the component, without recording the callbacks."""
        assert str(self.lab.activate(self.rtc)) == "RTC_OK"
        self.behaviour.calls.clear()

    def configure(self, **values: str) -> None:
        """Set parameters of the set `default`, as tools do."""
        for name, text in values.items():
            self.lab.rtm.set_configuration(self.rtc.getObjRef(), "default", name, text)
