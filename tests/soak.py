"""Long runs whose memory, descriptors and threads must not grow.

    python tests/soak.py [--share S] [calls|frames|rh3|network ...]

`calls`: 10,000,000 OpaqueRPC calls over TCP, client and server in this process. `frames`:
10,000,000 frames through `rtgen can hub`, a process of its own. `rh3`: 24 hours of the navigation
pipeline in simulated time. `network`: 24 hours of 126 CANopen slaves and their manager. `openrtm`:
an hour of the navigation pipeline as six processes of OpenRTM-aist-Python, at a fifth of their
rates; left out if that is not installed. A share of 0.01 runs a hundredth of each. Numbers in calls
and frames show losses and duplicates.

A line for each gives the growth of the resident memory (by linear regression, after the first
fifth), of descriptors and of threads. The exit code is 1 if the memory grows by more than 2 % of
itself over the run, if descriptors or threads grow, or if something was lost or duplicated.
"""

from __future__ import annotations

import argparse
import gc
import importlib
import importlib.util
import os
import socket
import statistics
import subprocess
import sys
import tempfile
import time
from collections.abc import Callable, Iterator
from contextlib import chdir
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from full_network import FullNetwork

ROOT = Path(__file__).resolve().parent.parent
sys.path[:0] = [str(ROOT / "tests/runtime/canopen"), str(ROOT / "tests/compiler/tecs")]

SAMPLES = 50
WARM = 0.2
GROWTH = 0.02
MILLION = 1_000_000
HOUR = 3600
FULL = {
    "calls": 10 * MILLION,
    "frames": 10 * MILLION,
    "rh3": 24 * HOUR,
    "network": 24 * HOUR,
    "openrtm": HOUR,
}
"""Units of a complete soak: calls, frames, simulated seconds, and real ones of `openrtm`."""

CDL = "signature sSoak { int32_t next([in] int32_t number); };\n"
_PAGE = os.sysconf("SC_PAGE_SIZE")

Steps = Iterator[tuple[int, tuple[int, ...]]]
"""Yields the number of units done, and the processes that do them."""


class WrongError(Exception):
    """Something was lost, doubled or changed."""


@dataclass(frozen=True, slots=True)
class Sample:
    """Resources of processes after a number of units."""

    done: int
    memory: int
    descriptors: int
    threads: int


def sample(done: int, processes: tuple[int, ...]) -> Sample:
    """Return the sum over the processes."""
    gc.collect()
    memory = descriptors = threads = 0
    for each in processes:
        folder = Path("/proc", str(each))
        memory += int((folder / "statm").read_text().split()[1]) * _PAGE
        descriptors += sum(1 for _ in (folder / "fd").iterdir())
        threads += sum(1 for _ in (folder / "task").iterdir())
    return Sample(done, memory, descriptors, threads)


def calls(count: int) -> Steps:
    """Make OpaqueRPC calls: each sends the previous result, the server returns it plus one."""
    from services import Generated

    from rtgen.compiler.frontends import cdl
    from rtgen.compiler.model.tecs import Signature
    from rtgen.runtime.opaque_rpc import NETWORK, TcpChannel, TcpServer
    from rtgen.tools.rpc.codecs import Service

    folder = ROOT / "build/soak"
    folder.mkdir(parents=True, exist_ok=True)
    (folder / "soak.cdl").write_text(CDL)
    [unit] = cdl.load([folder / "soak.cdl"], root=folder).model.tecs
    [signature] = [d for d in unit.declarations if isinstance(d, Signature)]
    service = Service(unit, signature, NETWORK)
    made = Generated(service)
    expected = 0

    def following(_self: object, number: int) -> int:
        nonlocal expected
        if number != expected:
            raise WrongError(f"call {number} came where {expected} was next")
        expected += 1
        return number + 1

    target = type("Target", (made.target,), {"next": following})()
    with TcpServer(made.unmarshaller(target, service.codec), "127.0.0.1", 0) as server:
        channel = TcpChannel(*server.address, timeout=60.0)
        proxy = made.proxy(channel, service.codec)
        for number in range(count):
            if proxy.next(number) != number + 1:
                raise WrongError(f"call {number} got another answer")
            yield number + 1, (os.getpid(),)
        channel.close()


def frames(count: int) -> Steps:
    """Send batches of numbered frames from one client to another."""
    from hub_process import HubProcess

    from rtgen.runtime.canopen.bus.python_can import BusAddress, open_bus
    from rtgen.runtime.canopen.wire.frames import Frame

    batch = 200
    with HubProcess() as hub:
        options = (("host", hub.host), ("port", hub.port))
        ends = [
            open_bus(BusAddress("socketcand", "soak", options=options)) for _ in "ab"
        ]
        sender, receiver = ends
        processes = (os.getpid(), hub._process.pid)
        expected = 0
        for first in range(0, count, batch):
            for number in range(first, first + batch):
                if not sender.send(
                    Frame(number % 0x700 + 1, number.to_bytes(8, "little"))
                ):
                    raise WrongError(f"frame {number} was not taken")
            while expected < first + batch:
                events = receiver.receive_events(60.0, batch)
                if not events:
                    raise WrongError(f"frame {expected} has not come")
                for event in events:
                    frame = getattr(event, "frame", event)
                    if int.from_bytes(frame.data, "little") != expected:
                        raise WrongError(f"{frame} came where {expected} was next")
                    expected += 1
            yield first + batch, processes
        for end in ends:
            end.close()


def rh3(seconds: int) -> Steps:
    """Run the navigation pipeline, which also goes on after it has reached the goal."""
    from rtgen import runtime
    from rtgen.compiler.project import load
    from rtgen.compiler.systems.reading import read_file
    from rtgen.tools.running.assembly import assemble
    from rtgen.tools.running.factories import Factories

    with chdir(ROOT):
        project = load()
        profile = read_file(Path("specs/navigation/rh3_goal.xml"))[0]
        assert profile is not None
        factories = Factories(project)
        clock = runtime.SimulatedClock()
        with assemble(profile, factories, clock, (), ()) as system:
            for second in range(1, seconds + 1):
                system.run(second * runtime.SECOND)
                yield second, (os.getpid(),)


def network(seconds: int) -> Steps:
    """Run 126 slaves that listen to each other; samples are checked each ten seconds."""
    from full_network import FullNetwork

    whole = FullNetwork()
    whole.run(3)
    for second in range(13, seconds + 13, 10):
        whole.run(second)
        _forget(whole)
        yield second - 3, (os.getpid(),)


def openrtm(seconds: int) -> Steps:
    """Run the navigation pipeline, with a process and a manager of OpenRTM for each component."""
    with tempfile.TemporaryDirectory() as out:
        command = [sys.executable, "-m", "rtgen", "generate", "-q", "-o", out]
        subprocess.run([*command, "--target", "openrtm"], cwd=ROOT, check=True)
        folder = Path(out, "generated/openrtm/rh3_goal")
        with socket.create_server(("127.0.0.1", 0)) as found:
            place = f"127.0.0.1:{found.getsockname()[1]}"
        arguments = ["--nameserver", place, "--rate-scale", "0.2"]
        _script(folder / "start.sh", *arguments)
        try:
            files = folder.glob("run/*.pid")
            processes = tuple(int(file.read_text()) for file in files)
            begun = time.monotonic()
            while (done := int(time.monotonic() - begun)) < seconds:
                time.sleep(1)
                if ended := [p for p in processes if not Path(f"/proc/{p}").exists()]:
                    raise WrongError(f"processes have ended: {ended}")
                yield done + 1, processes
            started = sorted(file.stem for file in folder.glob("run/*.pid"))
            _require_running(place, [name for name in started if name != "omniNames"])
        finally:
            _script(folder / "stop.sh")


def _require_running(naming_service: str, names: list[str]) -> None:
    """Check that components are ACTIVE, except PositionInput in ERROR after it reached the goal."""
    rtc, corba = (importlib.import_module(name) for name in ("RTC", "omniORB.CORBA"))
    orb = corba.ORB_init([], "omniORB4")
    for name in names:
        address = f"corbaname::{naming_service}#{name}.rtc"
        component = orb.string_to_object(address)._narrow(rtc.RTObject)
        state = component.get_owned_contexts()[0].get_component_state(component)
        wanted = [rtc.ACTIVE_STATE]
        if name == "PositionInput0":
            wanted.append(rtc.ERROR_STATE)
        if state not in wanted:
            raise WrongError(f"{name} is in {state}")


def _script(file: Path, *arguments: str) -> None:
    environment = {**os.environ, "PYTHON": sys.executable}
    command = [sys.executable] if file.suffix == ".py" else []
    done = subprocess.run(
        [*command, str(file), *arguments],
        env=environment,
        capture_output=True,
        text=True,
        check=False,
    )
    if done.returncode:
        raise WrongError(f"{file.name}: {done.stderr.strip()}")


def _forget(whole: FullNetwork) -> None:
    """Check the received samples, and drop all but the last one of each slave."""
    if wrong := whole.lost_or_doubled():
        raise WrongError(f"{wrong} samples were lost or doubled")
    for samples in whole.collector.samples.values():
        del samples[:-1]
    for slave in whole.slaves:
        del slave.heard[:-1]


PARTS: dict[str, Callable[[int], Steps]] = {
    "calls": calls,
    "frames": frames,
    "rh3": rh3,
    "network": network,
    "openrtm": openrtm,
}


def soak(name: str, share: float) -> tuple[str, bool]:
    """Run a part; return a line about it, and whether nothing grew."""
    count = max(1, round(FULL[name] * share))
    begun = time.perf_counter()
    found: list[Sample] = []
    due, wrong = 0.0, ""
    try:
        for done, processes in PARTS[name](count):
            if done >= due:
                found.append(sample(done, processes))
                due = done + count / SAMPLES
    except WrongError as error:
        wrong = f"; {error}"
    taken = time.perf_counter() - begun
    if len(found) < 2:
        return f"{name:<8} too few samples for a slope{wrong}", False
    warm = [each for each in found if each.done >= WARM * found[-1].done]
    slope, start = statistics.linear_regression(
        [each.done for each in warm], [each.memory for each in warm]
    )
    whole = found[-1].done
    growth = slope * (whole - warm[0].done)
    descriptors = warm[-1].descriptors - warm[0].descriptors
    threads = warm[-1].threads - warm[0].threads
    flat = growth <= GROWTH * start and descriptors <= 0 and threads <= 0
    unit, per = ("M", MILLION) if name in ("calls", "frames") else ("h", HOUR)
    line = (
        f"{name:<8} {whole / per:8.2f} {unit} in {taken:6.0f} s: {start / MILLION:.1f} MB"
        f" {slope * per / 1000:+.1f} kB/{unit} ({growth / MILLION:+.2f} MB),"
        f" descriptors {warm[-1].descriptors} {descriptors:+d},"
        f" threads {warm[-1].threads} {threads:+d}{wrong}"
    )
    return line, flat and not wrong


def main() -> int:
    """Run the named parts, or all."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("parts", nargs="*", choices=[*PARTS, []], metavar="PART")
    parser.add_argument("--share", type=float, default=1.0)
    given = parser.parse_args()
    good = True
    for name in given.parts or PARTS:
        if name == "openrtm" and importlib.util.find_spec("OpenRTM_aist") is None:
            print("openrtm  left out: OpenRTM-aist-Python is not installed")
            continue
        line, sound = soak(name, given.share)
        print(line if sound else f"{line}  NOT FLAT", flush=True)
        good &= sound
    return 0 if good else 1


if __name__ == "__main__":
    sys.exit(main())
