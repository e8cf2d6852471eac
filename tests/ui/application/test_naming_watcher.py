"""The watcher of naming services beside calls that look up objects of the same process."""

from __future__ import annotations

import subprocess
import sys

import pytest
from patience import PATIENCE

pytest.importorskip("omniORB", reason="omniORBpy is not installed")

PROGRAM = """
import threading
from refrobots._idl.basic_data_type import TimedDouble
from rtgen import runtime
from rtgen.runtime.corba.name_server import NameServer
from rtgen.runtime.corba.transport import NamedCorba
from rtgen.ui.naming_watcher import NamingWatcher

class Node(runtime.Component):
    profile = runtime.ComponentProfile("Node", rate=100.0)

    def __init__(self, instance):
        super().__init__(instance)
        self.add_out_port("out", TimedDouble)
        self.add_in_port("in", TimedDouble)

states, found = [], set()
enough, ended = threading.Event(), threading.Event()

def publish(state):
    states.append(state)
    if sum(len(each.connections) for each in states) >= 1000:
        enough.set()
    return False

with (
    NameServer() as server,
    NamedCorba(name_server=server.address) as transport,
    runtime.System(runtime.RealClock(), transport) as system,
):
    for name in ("A0", "B0"):
        system.add(Node(name))
    system.connect(("A0", "out"), ("B0", "in"))
    [port, *_] = transport.rt_objects.ports_at("A0", "out")

    def look_up():
        while not ended.is_set():
            found.add(transport.rt_objects.own(port.reference))

    looking = [threading.Thread(target=look_up) for _ in range(2)]
    watcher = NamingWatcher([server.address], publish, print, period=0.001)
    for thread in looking:
        thread.start()
    enough.wait()
    ended.set()
    for thread in looking:
        thread.join()
    watcher.close()
    assert found == {port}
"""


@pytest.mark.nightly
def test_its_rounds_go_on_while_objects_are_looked_up() -> None:
    """A deadlock of omniORB's lock and that of the interpreter would stop the process."""
    command = [sys.executable, "-c", PROGRAM]
    subprocess.run(command, check=True, timeout=PATIENCE)
