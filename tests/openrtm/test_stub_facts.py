"""What OpenRTM-aist-Python 2.1 does, fact for fact: the stub, or the real one if installed."""

from __future__ import annotations

import time
from collections.abc import Callable, Iterator
from typing import Any

import pytest


class Lab:
    """Makes components of one call, and ends them."""

    def __init__(self, rtm: Any, manager: Any) -> None:
        self.rtm = rtm
        self.manager = manager
        self.made: list[Any] = []
        self.count = 0

    def component(self, *specification: str, query: str = "", **callbacks: Any) -> Any:
        """A new component; `callbacks` become its methods, `calls` lists those that ran."""
        self.count += 1
        kind = f"Lab{id(self)}x{self.count}"
        rtm = self.rtm
        spec = [
            *("implementation_id", kind, "type_name", kind, "category", "lab"),
            *("description", "a test", "version", "1.0", "vendor", "lab"),
            *specification,
            "",
        ]

        class Tested(rtm.DataFlowComponentBase):  # type: ignore[misc, name-defined]
            def __init__(self, manager: Any) -> None:
                rtm.DataFlowComponentBase.__init__(self, manager)
                self.calls: list[str] = []

        import RTC

        for name in (
            *("onInitialize", "onFinalize", "onStartup", "onShutdown", "onActivated"),
            *("onDeactivated", "onExecute", "onStateUpdate", "onRateChanged"),
            *("onAborting", "onError", "onReset"),
        ):
            setattr(Tested, name, self._noted(name, callbacks.get(name), RTC.RTC_OK))
        self.manager.registerFactory(
            rtm.Properties(defaults_str=spec), Tested, rtm.Delete
        )
        made = self.manager.createComponent(kind + query)
        if made is not None:
            self.made.append(made)
        return made

    @staticmethod
    def _noted(name: str, callback: Any, code: Any) -> Callable[..., Any]:
        def noted(self: Any, *arguments: Any) -> Any:
            self.calls.append(name)
            return code if callback is None else callback(self, *arguments)

        return noted

    def activate(self, component: Any) -> Any:
        return self.rtm.activate(component.getObjRef())

    def state(self, component: Any) -> Any:
        return self.rtm.get_state(component.getObjRef())[1]

    def tick(self, component: Any) -> None:
        """One cycle of the component's own context, and waits for its end."""
        import OpenRTM

        context = component.getObjRef().get_owned_contexts()[0]
        context._narrow(OpenRTM.ExtTrigExecutionContextService).tick()
        time.sleep(0.02 if hasattr(self.rtm, "Task") else 0)

    def connect(self, first: Any, second: Any, **properties: str) -> Any:
        """Connects two ports; keywords are data port properties, `__` for a dot."""
        asked = self.rtm.Properties()
        for key, value in properties.items():
            asked.setProperty("dataport." + key.replace("__", "."), value)
        return self.rtm.connect("wire", asked, first.getPortRef(), second.getPortRef())


@pytest.fixture
def lab(rtm: Any, manager: Any) -> Iterator[Lab]:
    made = Lab(rtm, manager)
    yield made
    for component in made.made:
        component.exit()


def test_component_lives(lab: Lab) -> None:
    import RTC

    component = lab.component()
    assert component.calls == ["onInitialize", "onStartup"]
    assert lab.state(component) == RTC.INACTIVE_STATE
    assert lab.activate(component) == RTC.RTC_OK
    assert component.calls[2] == "onActivated"
    lab.tick(component)
    assert component.calls[-2:] == ["onExecute", "onStateUpdate"]


def ports(lab: Lab, name: str = "p") -> tuple[Any, Any, Any, Any]:
    """Two components, the first one's OutPort, the second one's InPort."""
    import RTC

    def add_out(self: Any) -> Any:
        self.out = lab.rtm.OutPort(name, RTC.TimedLong(RTC.Time(0, 0), 0))
        self.addOutPort(name, self.out)
        return RTC.RTC_OK

    def add_in(self: Any) -> Any:
        self.inp = lab.rtm.InPort(name, RTC.TimedLong(RTC.Time(0, 0), 0))
        self.addInPort(name, self.inp)
        return RTC.RTC_OK

    first = lab.component(onInitialize=add_out)
    second = lab.component(onInitialize=add_in)
    return first, second, first.out, second.inp


def long(value: int) -> Any:
    import RTC

    return RTC.TimedLong(RTC.Time(1, 2), value)


def read_all(port: Any) -> list[int]:
    found = []
    while port.isNew():
        found.append(port.read().data)
    return found


def test_ten_writes_leave_eight(lab: Lab) -> None:
    import RTC

    _, _, out, inp = ports(lab)
    assert not out.write(long(0))
    assert lab.connect(out, inp) == RTC.RTC_OK
    assert all(out.write(long(number)) for number in range(10))
    assert read_all(inp) == list(range(2, 10))
    assert inp.read().data == 9
