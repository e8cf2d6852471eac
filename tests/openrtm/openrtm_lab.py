"""Components created by tests of OpenRTM's behaviour."""

from __future__ import annotations

import itertools
from collections.abc import Callable
from typing import Any

import middleware
from patience import until

NUMBERS = itertools.count()
CALLBACKS = (
    *("onInitialize", "onFinalize", "onStartup", "onShutdown", "onActivated"),
    *("onDeactivated", "onExecute", "onStateUpdate", "onRateChanged"),
    *("onAborting", "onError", "onReset"),
)


def resolved(rtm: Any, naming_service: str, name: str, process: Any = None) -> Any:
    """Return the component of a name, once it exists; its process must be alive."""
    import RTC
    from omniORB import CORBA

    naming = rtm.CorbaNaming(rtm.Manager.instance().getORB(), naming_service)

    def found() -> Any:
        assert process is None or process.poll() is None, "the process has ended"
        try:
            return naming.resolve(name)._narrow(RTC.RTObject)
        except CORBA.Exception:
            return None

    until(found, 60.0)
    return found()


class Lab:
    """Creates components of a manager, drives and connects them, and ends them."""

    def __init__(self, rtm: Any, manager: Any) -> None:
        self.rtm = rtm
        self.manager = manager
        self.made: list[Any] = []

    def kind(self, *specification: str, **callbacks: Any) -> str:
        """Register a class of components and return its name.

        `callbacks` become its methods; `calls` of a component lists those that ran.
        """
        import RTC

        name = f"Lab{next(NUMBERS)}"
        rtm = self.rtm

        def begin(self: Any, manager: Any) -> None:
            self.calls = []
            rtm.DataFlowComponentBase.__init__(self, manager)

        methods = {
            each: _noted(each, callbacks.get(each), RTC.RTC_OK) for each in CALLBACKS
        }
        made = type(name, (rtm.DataFlowComponentBase,), {"__init__": begin, **methods})
        profile = rtm.Properties(
            defaults_str=[
                *("implementation_id", name, "type_name", name, "category", "lab"),
                *("description", "a test", "version", "1.0", "vendor", "labs"),
                *specification,
                "",
            ]
        )
        assert self.manager.registerFactory(profile, made, rtm.Delete)
        return name

    def unused(self, name: str) -> str:
        """Return an unused instance name: a name stays reserved for a second."""
        return f"{name}{next(NUMBERS)}"

    def create(self, text: str) -> Any:
        """Return the result of `createComponent`."""
        made = self.manager.createComponent(text)
        if made is not None:
            self.made.append(made)
        return made

    def component(self, *specification: str, **callbacks: Any) -> Any:
        """Return a component of a class of its own."""
        return self.create(self.kind(*specification, **callbacks))

    def close(self) -> None:
        for component in self.made:
            component.exit()

    def context(self, component: Any) -> Any:
        return component.getObjRef().get_owned_contexts()[0]

    def activate(self, component: Any) -> Any:
        return self.rtm.activate(component.getObjRef())

    def deactivate(self, component: Any) -> Any:
        return self.rtm.deactivate(component.getObjRef())

    def reset(self, component: Any) -> Any:
        return self.rtm.reset(component.getObjRef())

    def state(self, component: Any) -> Any:
        return self.rtm.get_state(component.getObjRef())[1]

    def tick(self, component: Any) -> list[str]:
        """Run one cycle of the component's own context; return the executed callbacks."""
        import OpenRTM

        def idle() -> bool:
            # The real one's worker runs the cycle; a tick meanwhile is lost.
            return not middleware.REAL or not component._eclist[0]._workerthread._ticked

        until(idle)
        before = len(component.calls)
        self.context(component)._narrow(OpenRTM.ExtTrigExecutionContextService).tick()
        until(idle)
        found: list[str] = component.calls[before:]
        return found

    def connect(self, first: Any, second: Any, **properties: str) -> Any:
        """Connect data ports; keywords are properties `dataport.`, with `__` for a dot."""
        asked = self.rtm.Properties()
        for key, value in properties.items():
            asked.setProperty("dataport." + key.replace("__", "."), value)
        return self.join(first, second, asked)

    def join(self, first: Any, second: Any, properties: Any = None) -> Any:
        """Connect ports."""
        asked = self.rtm.Properties() if properties is None else properties
        return self.rtm.connect("wire", asked, first.getPortRef(), second.getPortRef())

    def out_port(self, value: Any, name: str = "data") -> Any:
        """Return an OutPort of a new component."""
        return self._with_port(self.rtm.OutPort(name, value), "addOutPort", name)

    def in_port(self, value: Any, name: str = "data") -> Any:
        """Return an InPort of a new component."""
        return self._with_port(self.rtm.InPort(name, value), "addInPort", name)

    def _with_port(self, port: Any, add: str, name: str) -> Any:
        assert getattr(self.component(), add)(name, port)
        return port


def _noted(name: str, callback: Any, code: Any) -> Callable[..., Any]:
    def noted(self: Any, *arguments: Any) -> Any:
        self.calls.append(name)
        return code if callback is None else callback(self, *arguments)

    noted.__name__ = name
    return noted


def answers(*codes: Any) -> Callable[..., Any]:
    """Return a callback that returns one code after the other, then the last one repeatedly."""
    left = list(codes)

    def callback(self: Any, *arguments: Any) -> Any:
        return left.pop(0) if len(left) > 1 else left[0]

    return callback
