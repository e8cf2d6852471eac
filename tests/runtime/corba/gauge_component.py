"""A running component, and its reports of `rtgen conformance`."""

from __future__ import annotations

import importlib
from collections.abc import Collection, Iterator
from contextlib import closing, contextmanager
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from rtgen.api import compile as compiled
from rtgen.runtime import RTC_OK, RealClock, System
from rtgen.runtime.corba.naming import Naming
from rtgen.runtime.corba.orb import Orb
from rtgen.runtime.corba.rt_objects.foreign import located
from rtgen.runtime.corba.rt_objects.objects import Exported
from rtgen.runtime.corba.transport import NamedCorba
from rtgen.tools.components.chosen_component import chosen
from rtgen.tools.conformance.check import Permission
from rtgen.tools.conformance.report import Report, Verdict
from rtgen.tools.conformance.rtc.component import RtcUnderTest
from rtgen.tools.conformance.rtc.expected import Expected
from rtgen.tools.conformance.rtc.testing import checked

PATIENCE = 5.0
"""Time for a working component to reach a state [s]."""
SOON = 0.2
"""Time-out for a component that never reaches it [s]."""

IDL = """module Bench {
  struct Level { long value; };
  enum Mode { SLOW, FAST };
  interface Valve { void open(); };
  interface Pump { void run(); };
};

/** Measures. */
@rtc(category="Test", vendor="labs", version="2.1.0", rate=200.0)
component Gauge {
  consumes Bench::Level level;
  publishes Bench::Level shown;
  @port("valves") provides Bench::Valve own;
  @port("valves") uses Bench::Pump other;
  @default(2.0) @min(0.5) @max(8.0) attribute double gain;
  @default(3) @constraint("x>0") attribute long count;
  attribute Bench::Mode mode;
  attribute sequence<double> weights;
  attribute string label;
};

component Idle { publishes Bench::Level shown; };
"""
SETTINGS = """[sources]
paths = ["gauge.idl"]
[output]
package = "gaugebot"
skeletons = "src/gaugenodes"
"""


def definition(file: Path, component: str = "Gauge") -> Expected:
    """Return the expectations of a definition file."""
    model = compiled([file])
    [name] = (source.name for source in model.files if source.main)
    return Expected(model, chosen(model, name, component))


def failed(report: Report) -> list[str]:
    return [o.check for o in report.outcomes if o.verdict is Verdict.FAILED]


@dataclass(frozen=True)
class Bench:
    """A running Gauge, its definition, and the address of its naming service."""

    gauge: Any
    expected: Expected
    names: str

    @property
    def context(self) -> Any:
        [context] = self.gauge.get_owned_contexts()
        return context

    @property
    def state(self) -> str:
        return str(self.context.get_component_state(self.gauge).name)

    def report(
        self,
        permissions: Collection[Permission] = tuple(Permission),
        patience: float = PATIENCE,
        expected: Expected | None = None,
    ) -> Report:
        place = f"{self.names}/Gauge0.rtc"
        with closing(Orb()) as orb:
            exported = Exported(orb)
            found = located(place, exported, lambda to: Naming(orb.orb, to))
            rtc = RtcUnderTest(expected or self.expected, found, exported, patience)
            return checked(rtc, "Gauge0", "gauge.idl", permissions)

    def failed(self, *permissions: Permission) -> list[str]:
        """Return the names of the checks that fail."""
        return failed(self.report(permissions or tuple(Permission)))


@contextmanager
def serving(names: str) -> Iterator[System]:
    """Yield a system whose components are found by a naming service."""
    with (
        NamedCorba(name_server=names) as transport,
        System(RealClock(), transport) as system,
    ):
        yield system


@contextmanager
def running(folder: Path, names: str) -> Iterator[Bench]:
    """Yield the component of a generated project, in this process."""
    module = importlib.import_module("gaugebot.components.gauge")
    bench = importlib.import_module("gaugebot.bench")

    class Valve(bench.Valve):  # type: ignore[misc, name-defined]
        def open(self) -> None:
            """Do nothing."""

    class Gauge(module.GaugeBase):  # type: ignore[misc, name-defined]
        def on_initialize(self) -> Any:
            self.own.set_servant(Valve())
            return RTC_OK

    with serving(names) as system:
        made = Gauge("Gauge0")
        system.add(made, 200.0)
        system.run(until_ns=1)
        yield Bench(made, definition(folder / "gauge.idl"), names)
