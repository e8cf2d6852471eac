"""One case of `realtime.py`: components that tick for some seconds; writes its figures as JSON.

python realtime_ends.py shared|own|relays|loop|rclpy|openrtm COMPONENTS RATE SECONDS
"""

from __future__ import annotations

import importlib
import json
import os
import sys
import time
from collections.abc import Callable
from typing import Any

SETTLE = 0.3
"""Time before the measurement [s]."""
NS = 1_000_000_000

Tick = Callable[[int], None]
"""What a component calls in each tick, with its number."""


class Meter:
    """Counts ticks of all components, and the times of those of the first."""

    def __init__(self, components: int) -> None:
        self.ticks = [0] * components
        self.stamps: list[int] = []

    def tick(self, number: int) -> None:
        """Count a tick."""
        self.ticks[number] += 1
        if number == 0:
            self.stamps.append(time.monotonic_ns())


def rtgen(kind: str, components: int, rate: float, meter: Meter) -> Any:
    """Return a function that runs the components for some seconds."""
    from rtgen.runtime import RTC_OK, Component, RealClock, ReturnCode_t, System
    from rtgen.runtime.library.rtc import TimedLong

    class Counting(Component):
        def __init__(self, number: int) -> None:
            super().__init__(f"counting{number}")
            self.number = number

        def on_execute(self, ec_id: int) -> ReturnCode_t:
            meter.tick(self.number)
            return RTC_OK

    class Relay(Counting):
        def __init__(self, number: int) -> None:
            super().__init__(number)
            self.input = self.add_in_port("in", TimedLong)
            self.output = self.add_out_port("out", TimedLong)

        def on_execute(self, ec_id: int) -> ReturnCode_t:
            meter.tick(self.number)
            if self.number == 0:
                self.output.write(TimedLong())
            elif self.input.is_new():
                self.output.write(self.input.read(), move=True)
            return RTC_OK

    system = System(RealClock(), threads="own" if kind == "own" else "shared")
    for number in range(components):
        component = (Relay if kind == "relays" else Counting)(number)
        system.add(component, rate)
        if kind == "relays" and number:
            source = f"counting{number - 1}"
            system.connect((source, "out"), (component.instance_name, "in"))
        system.activate(component.instance_name)
    return lambda seconds: system.run(until_ns=system.time + int(seconds * NS))


def loop(components: int, rate: float, meter: Meter) -> Any:
    """Return a function that calls functions in a bare loop; of missed ones, it calls the last."""

    def run(seconds: float) -> None:
        period = round(NS / rate)
        due = time.monotonic_ns()
        end = due + int(seconds * NS)
        calls = [
            lambda number=number: meter.tick(number) for number in range(components)
        ]
        while due < end:
            delay = due - time.monotonic_ns()
            if delay > 0:
                time.sleep(delay / NS)
            for call in calls:
                call()
            due += period
            due += max(0, time.monotonic_ns() - due) // period * period

    return run


def rclpy(components: int, rate: float, meter: Meter) -> Any:
    """Return a function that spins a node with timers."""
    ros: Any = importlib.import_module("rclpy")
    ros.init()
    node = ros.create_node("meter")
    for number in range(components):
        node.create_timer(1.0 / rate, lambda number=number: meter.tick(number))
    executor = importlib.import_module("rclpy.executors").SingleThreadedExecutor()
    executor.add_node(node)

    def run(seconds: float) -> None:
        end = time.monotonic() + seconds
        while (remaining := end - time.monotonic()) > 0:
            executor.spin_once(timeout_sec=remaining)

    return run


def openrtm(components: int, rate: float, meter: Meter) -> Any:
    """Return a function that waits while components of a manager tick."""
    rtm: Any = importlib.import_module("OpenRTM_aist")
    rtc: Any = importlib.import_module("RTC")
    numbers = iter(range(components))

    class Counting(rtm.DataFlowComponentBase):  # type: ignore[misc]
        def onInitialize(self) -> Any:  # noqa: N802
            self.number = next(numbers)
            return rtc.RTC_OK

        def onExecute(self, ec_id: int) -> Any:  # noqa: N802
            meter.tick(self.number)
            return rtc.RTC_OK

    options = {
        "corba.endpoints": "127.0.0.1:",
        "exec_cxt.periodic.rate": str(rate),
        "logger.enable": "NO",
        "manager.shutdown_on_nortcs": "NO",
        "naming.enable": "NO",
    }
    settings = [t for key, value in options.items() for t in ("-o", f"{key}:{value}")]
    profile = ["implementation_id", "Counting", "type_name", "Counting"]
    profile += ["version", "1.0", "max_instance", str(components), ""]
    manager = rtm.Manager.init(["benchmark", *settings])
    manager.activateManager()
    manager.runManager(True)
    manager.registerFactory(rtm.Properties(defaults_str=profile), Counting, rtm.Delete)
    for _ in range(components):
        rtm.activate(manager.createComponent("Counting").getObjRef())
    return time.sleep


def main(kind: str, components: int, rate: float, seconds: float) -> None:
    """Measure one kind."""
    meter = Meter(components)
    if kind in ("shared", "own", "relays"):
        run = rtgen(kind, components, rate, meter)
    else:
        run = {"loop": loop, "rclpy": rclpy, "openrtm": openrtm}[kind](
            components, rate, meter
        )
    run(SETTLE)
    before = sum(meter.ticks)
    meter.stamps.clear()
    processor, begun = time.process_time(), time.monotonic()
    run(seconds)
    took = time.monotonic() - begun
    used = time.process_time() - processor
    ticks = sum(meter.ticks) - before
    period = NS / rate
    pairs = zip(meter.stamps, meter.stamps[1:], strict=False)
    off = sorted(abs(b - a - period) / 1000 for a, b in pairs) or [0.0]
    figures = {
        "core": used / took,
        "tick": used / max(ticks, 1) * 1e6,
        "lost": max(0.0, 1.0 - ticks / (components * int(took * rate) or 1)),
        "jitter": off[len(off) // 2],
        "worst": off[int(len(off) * 0.99)],
        "late": (took - seconds) * 1e6,
    }
    print(json.dumps(figures), flush=True)
    os._exit(0)  # without waiting for threads of OpenRTM


if __name__ == "__main__":
    main(sys.argv[1], int(sys.argv[2]), float(sys.argv[3]), float(sys.argv[4]))
