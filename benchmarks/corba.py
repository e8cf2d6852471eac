"""Calls between two processes by `--transport corba` compared with omniidl's stubs, on one ORB.

    python benchmarks/corba.py

One server process has a component with a provider and a servant of omniidl's skeleton; the client
calls both by the same ORB, so only the code around omniORB differs. Batches of 100 calls of both
alternate; the ratio is the median of those of 200 such pairs. All processes are bound to one
processor if the system can do that (see `rpc.py`).
"""

from __future__ import annotations

import importlib
import os
import shutil
import subprocess
import sys
import sysconfig
import tempfile
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

from rpc import COLUMNS, PAIRS, add, compared, ratio
from tables import Arguments, Results, Table

LIMIT = 1.5
"""Maximum ratio to a call by omniidl's stubs."""
SECOND = 1_000_000_000
IDL = """
module Bench {
  enum Gear { LOW, HIGH };
  struct Pose { double x; double y; double theta; Gear shifted; };
  typedef sequence<Pose> Poses;
  union Either switch (Gear) { case LOW: double number; case HIGH: string text; };
  interface Calls {
    void nothing();
    Pose move(in Pose from_here, in double distance);
    Poses reversed(in Poses path);
    Either choose(in Either value);
    any anything(in any value);
  };
};
"""
PROJECT = '[sources]\npaths = ["bench.idl"]\n[output]\npackage = "ours"\n'


def prepare(folder: Path) -> None:
    """Generate the code of both."""
    (folder / "bench.idl").write_text(IDL, encoding="utf-8")
    (folder / "rtgen.toml").write_text(PROJECT, encoding="utf-8")
    command = [sys.executable, "-m", "rtgen", "generate", "-q"]
    subprocess.run(command, cwd=folder, check=True)
    scripts = sysconfig.get_path("scripts")
    omniidl = shutil.which("omniidl", path=f"{scripts}{os.pathsep}{os.environ['PATH']}")
    assert omniidl is not None
    subprocess.run([omniidl, "-bpython", "bench.idl"], cwd=folder, check=True)


@contextmanager
def system(folder: Path, names: str, kind: str) -> Iterator[tuple[Any, Any, Any]]:
    """Yield a system with one component that provides or uses `Bench::Calls`, and its ORB."""
    sys.path[:0] = [str(folder), str(folder / "generated")]
    from rtgen.runtime import Component, ComponentProfile, RealClock, System
    from rtgen.runtime.corba.transport import NamedCorba

    bench = importlib.import_module("ours.bench")

    class Node(Component):
        profile = ComponentProfile(kind, rate=1.0)

        def __init__(self) -> None:
            super().__init__(f"{kind}0")
            if kind == "Server":
                calls = self.add_provider("calls", "Calls", bench.Calls)
                calls.set_servant(servant(bench.Calls))
            else:
                self.calls = self.add_consumer("calls", "Calls", bench.Calls)

    with (
        NamedCorba(name_server=names, timeout=5.0) as transport,
        System(RealClock(), transport) as running,
    ):
        node = Node()
        running.add(node)
        yield running, node, transport


def servant(base: Any) -> Any:
    """Return a servant, the same on both sides."""
    methods = {
        "nothing": lambda self: None,
        "move": lambda self, pose, distance: pose,
        "reversed": lambda self, path: path[::-1],
        "choose": lambda self, value: value,
        "anything": lambda self, value: value,
    }
    return type("Servant", (base,), methods)()


def serve(folder: Path, names: str) -> None:
    """Run the server process."""
    with system(folder, names, "Server") as (running, node, _):
        running.activate(node.instance_name)
        running.run(until=lambda _: node.is_active)
        omniorb = importlib.import_module("omniORB")
        peer = servant(importlib.import_module("Bench__POA").Calls)
        root = omniorb.orb.resolve_initial_references("RootPOA")
        root._get_the_POAManager().activate()
        print(omniorb.orb.object_to_string(peer._this()), flush=True)
        sys.stdin.read()


def cases(side: Any, corba: Any, node: bool) -> dict[str, tuple[str, tuple[Any, ...]]]:
    """Return operation and arguments of each case."""
    pose = side.Pose(1.0, 2.0, 0.5, side.HIGH)
    path = [side.Pose(float(i), 2.0, 0.5, side.LOW) for i in range(50)]
    if node:
        from rtgen.runtime.marshalling.descriptors import StringDescriptor
        from rtgen.runtime.values import AnyValue

        anys = AnyValue(side.Pose, pose), AnyValue(StringDescriptor(), "some text")
    else:
        anys = corba.Any(side._tc_Pose, pose), corba.Any(corba._tc_string, "some text")
    return {
        "empty": ("nothing", ()),
        "struct": ("move", (pose, 1.0)),
        "sequence of 50 structs": ("reversed", (path,)),
        "union": ("choose", (side.Either(side.HIGH, "some text"),)),
        "any of a struct": ("anything", anys[:1]),
        "any of a string": ("anything", anys[1:]),
    }


def main() -> int:
    """Print the figures; return 1 if a limit is exceeded."""
    chosen = Arguments(__doc__, rounds=PAIRS).parse_args()
    try:
        from rtgen.runtime.corba.name_server import NameServer
    except ImportError as error:
        print(f"left out, {error}")
        return 0
    if sys.platform == "linux":
        os.sched_setaffinity(0, {min(os.sched_getaffinity(0))})
    with (
        Results(__file__, chosen) as results,
        tempfile.TemporaryDirectory() as name,
        NameServer() as names,
    ):
        table = results.table("calls", "a call", *COLUMNS)
        folder = Path(name)
        prepare(folder)
        command = [sys.executable, __file__, str(folder), names.address]
        with subprocess.Popen(
            command, stdin=subprocess.PIPE, stdout=subprocess.PIPE, text=True
        ) as process:
            assert process.stdin is not None
            assert process.stdout is not None
            try:
                reference = process.stdout.readline()
                slow = measured(table, folder, names.address, reference, chosen.rounds)
                return int(slow and not chosen.smallest)
            finally:
                process.stdin.close()


def measured(
    table: Table, folder: Path, names: str, reference: str, pairs: int
) -> bool:
    """Measure all cases on both sides; return whether a limit is exceeded."""
    slow = False
    with system(folder, names, "Client") as (running, node, transport):
        running.connect(("Client0", "calls"), ("Server0", "calls"))
        transport.await_others(5.0)
        corba = importlib.import_module("omniORB.CORBA")
        theirs = importlib.import_module("Bench")
        orb = importlib.import_module("omniORB").orb
        peer = orb.string_to_object(reference.strip())._narrow(theirs.Calls)
        sides = (
            (peer, cases(theirs, corba, False)),
            (
                node.calls.object,
                cases(importlib.import_module("ours.bench"), corba, True),
            ),
        )
        for case in sides[0][1]:
            calls = [bound(stub, *known[case]) for stub, known in sides]
            times, ours = compared(calls[0], calls[1], pairs)
            value = ratio(times, ours)
            add(table, f"{case}, omniidl's stub", times)
            add(table, f"{case}, rtgen", ours, value, LIMIT)
            slow |= value > LIMIT
    return slow


def bound(
    stub: Any, operation: str, arguments: tuple[Any, ...]
) -> Callable[[], object]:
    """Return a call with its arguments."""
    method = getattr(stub, operation)
    return lambda: method(*arguments)


if __name__ == "__main__":
    if len(sys.argv) == 3 and Path(sys.argv[1]).is_dir():
        serve(Path(sys.argv[1]), sys.argv[2])
    else:
        sys.exit(main())
