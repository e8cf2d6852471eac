"""The evaluation of the RTM-TECS paper: 100 calls of an empty function, RTM to RTM and RTM to TECS.

    python benchmarks/rtm_tecs.py

RTM to RTM: an RTC calls another one by its service port in one process; the same between two
processes is a call of omniORBpy. RTM to TECS: an RTC calls the marshaller RTC, the marshaller the
communication RTC, and this a board in another process over TCP. The proxy alone is for comparison.
Each call is timed by itself; mean, spread (standard deviation) and range are medians of 20 series.
"""

from __future__ import annotations

import os
import statistics
import sys
import tempfile
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from functools import partial
from pathlib import Path
from typing import Any

import rpc
from tables import Arguments, Results, Table

from rtgen.runtime import (
    ACTIVE_STATE,
    SECOND,
    Component,
    ComponentProfile,
    RealClock,
    System,
)
from rtgen.runtime.opaque_rpc.communication import OpaqueRpcCommunication

CALLS, SERIES = 100, 20


@contextmanager
def active(*components: Any, joined: list[tuple[Any, Any]]) -> Iterator[None]:
    """Yield while a system of these components is ACTIVE in real time."""
    with System(RealClock()) as system:
        for component in components:
            system.add(component, 10.0)
        for consumer, provider in joined:
            system.connect(consumer, provider)
        for component in components:
            system.activate(component.instance_name)
        names = [component.instance_name for component in components]
        assert system.run(
            10 * SECOND, lambda s: all(s.state(n) is ACTIVE_STATE for n in names)
        )
        yield


def series(call: Callable[[], object]) -> list[float]:
    """Return the times of 100 calls in microseconds."""
    times = []
    for _ in range(CALLS):
        begun = time.perf_counter_ns()
        call()
        times.append((time.perf_counter_ns() - begun) / 1000)
    return times


def show(table: Table, name: str, call: Callable[[], object], rounds: int) -> float:
    """Print the figures of calls; return their mean."""
    series(call)
    runs = [series(call) for _ in range(rounds)]
    figures = [
        statistics.median(measure(run) for run in runs)
        for measure in (statistics.mean, statistics.stdev, min, max)
    ]
    table.add(name, *figures)
    return figures[0]


def main() -> int:
    """Print the table."""
    chosen = Arguments(__doc__, rounds=SERIES).parse_args()
    if sys.platform == "linux":
        os.sched_setaffinity(0, {min(os.sched_getaffinity(0))})
    with Results(__file__, chosen) as results, tempfile.TemporaryDirectory() as name:
        columns = [(title, ".1f") for title in ("mean", "spread", "least", "most")]
        table = results.table("series", "a call [µs]", *columns)
        show_ = partial(show, table, rounds=chosen.rounds)
        folder = Path(name)
        rpc.prepare(folder)
        marshallers = rpc.generated(folder, "empty.empty_marshaller")
        interface = marshallers.Empty

        class Servant(interface):  # type: ignore[misc, valid-type]
            def nothing(self) -> int:
                return 0

        ends = [(("Client0", "empty"), ("Server0", "empty"))]
        client, server = marshallers.EmptyClientBase("Client0"), provider(interface)
        server.empty.set_servant(Servant())
        with active(client, server, joined=ends):
            rtm = show_("RTM to RTM, one process", client.empty.object.nothing)
        try:
            with rpc.server("omniORBpy", folder) as reference:
                call = rpc.omniorb_call(reference, folder)
                rtm = show_("RTM to RTM, omniORBpy", call)
        except ImportError as error:
            print(f"RTM to RTM between processes: left out, {error}")
        with rpc.server("rtgen", folder) as port:
            show_("proxy to TECS", rpc.rtgen_call(port, folder))
            client = marshallers.EmptyClientBase("Client0")
            marshaller = marshallers.EmptyMarshaller("Marshaller0")
            link = OpaqueRpcCommunication("Communication0")
            link.configuration_sets.set("port", port)
            with active(
                client,
                marshaller,
                link,
                joined=[
                    (("Client0", "empty"), ("Marshaller0", "empty")),
                    (("Marshaller0", "communication"), ("Communication0", "service")),
                ],
            ):
                tecs = show_("RTM to TECS", client.empty.object.nothing)
        print(f"RTM to TECS takes {tecs / rtm:.2f} times the last RTM to RTM")
    return 0


def provider(interface: Any) -> Any:
    """Return the RTC that offers an interface."""

    class Server(Component):
        profile = ComponentProfile("Server", max_instances=0)

        def __init__(self) -> None:
            super().__init__("Server0")
            self.empty = self.add_provider("empty", "empty", interface)

    return Server()


if __name__ == "__main__":
    sys.exit(main())
