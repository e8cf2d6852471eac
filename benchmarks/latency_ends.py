"""One chain of `latency.py`; writes the median and the 99th percentile [us] as JSON.

python latency_ends.py periodic|arrival|own|rclpy SECONDS ORDER

ORDER has the numbers of the components as they are added, 0 is the source.
"""

from __future__ import annotations

import importlib
import json
import os
import sys
import time
from typing import Any

RATE = 100.0
NS = 1_000_000_000


def rtgen(kind: str, order: list[int], seconds: float) -> list[int]:
    """Return the latencies of a chain of components."""
    from rtgen.runtime import (
        RTC_OK,
        Component,
        ExecutionKind,
        RealClock,
        ReturnCode_t,
        System,
    )
    from rtgen.runtime.library.rtc import TimedLong

    latencies: list[int] = []
    begun: list[int] = []

    class Part(Component):
        def __init__(self, number: int) -> None:
            super().__init__(f"part{number}")
            self.number = number
            self.input = self.add_in_port("in", TimedLong)
            self.output = self.add_out_port("out", TimedLong)

        def on_execute(self, ec_id: int) -> ReturnCode_t:
            if self.number == 0:
                begun.append(time.monotonic_ns())
                self.output.write(TimedLong(data=len(begun) - 1))
            while self.input.is_new():
                sample = self.input.read()
                assert sample is not None
                if self.number == len(order) - 1:
                    latencies.append(time.monotonic_ns() - begun[sample.data])
                else:
                    self.output.write(sample, move=True)
            return RTC_OK

    with System(RealClock(), threads="own" if kind == "own" else "shared") as system:
        for number in order:
            is_periodic = kind == "periodic" or number == 0
            on = ExecutionKind.PERIODIC if is_periodic else ExecutionKind.EVENT_DRIVEN
            system.add(Part(number), RATE, kind=on)
        for number in range(1, len(order)):
            system.connect((f"part{number - 1}", "out"), (f"part{number}", "in"))
        for number in order:
            system.activate(f"part{number}")
        system.run(until_ns=int(0.2 * NS))
        latencies.clear()
        system.run(until_ns=system.time + int(seconds * NS))
    return latencies


def rclpy(length: int, seconds: float) -> list[int]:
    """Return the latencies of a chain of callbacks in one node."""
    ros: Any = importlib.import_module("rclpy")
    class_: Any = importlib.import_module("std_msgs.msg").Int64
    ros.init()
    node = ros.create_node("chain")
    publishers = [node.create_publisher(class_, f"t{n}", 10) for n in range(length)]
    latencies: list[int] = []

    def pass_on(number: int, message: Any) -> None:
        if number == length - 1:
            latencies.append(time.monotonic_ns() - message.data)
        else:
            publishers[number + 1].publish(message)

    for number in range(length):
        call = lambda message, number=number: pass_on(number, message)  # noqa: E731
        node.create_subscription(class_, f"t{number}", call, 10)
    node.create_timer(
        1 / RATE, lambda: publishers[0].publish(class_(data=time.monotonic_ns()))
    )
    executor = importlib.import_module("rclpy.executors").SingleThreadedExecutor()
    executor.add_node(node)
    end = time.monotonic() + seconds + 0.5
    while (remaining := end - time.monotonic()) > 0:
        if remaining > seconds:
            latencies.clear()
        executor.spin_once(timeout_sec=remaining)
    return latencies


def main(kind: str, seconds: float, text: str) -> None:
    """Measure one chain."""
    order = [int(number) for number in text.split(",")]
    is_rclpy = kind == "rclpy"
    found = rclpy(len(order) - 1, seconds) if is_rclpy else rtgen(kind, order, seconds)
    found.sort()
    figures = [found[int(len(found) * part)] / 1000 for part in (0.5, 0.99)]
    print(json.dumps(figures), flush=True)
    os._exit(0)  # without waiting for threads of ROS 2


if __name__ == "__main__":
    main(sys.argv[1], float(sys.argv[2]), sys.argv[3])
