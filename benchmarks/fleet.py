"""Costs of each engine by the number of processes and readers, and the costs of a fleet.

    python benchmarks/fleet.py [dds] [zenoh] [zenoh-router]

Each process has five topics of its own and reads five of its neighbour. The figures are the octets
of the loopback interface (run nothing else that uses it; on Linux, `unshare -n` gives the benchmark
its own), memory and processor time of the processes. The constants are fitted to 2, 4 and 8
processes; 12 are measured to check the extrapolation.
"""

from __future__ import annotations

import os
import statistics
import subprocess
import sys
import time
from contextlib import ExitStack
from pathlib import Path

from tables import Arguments, Results, Table

HERE = Path(__file__).parent
sys.path.insert(0, str(HERE.parent / "tests"))
sys.path.insert(0, str(HERE.parent / "generated"))

from fleet_model import Constants, Fleet, by_robot, by_site, fitted, flat  # noqa: E402
from media import engine, medium_at  # noqa: E402

from refrobots import rtc  # noqa: E402
from rtgen.runtime.distribution.data import encoder  # noqa: E402
from rtgen.runtime.distribution.medium import Qos, Topic  # noqa: E402

ENGINES = ("dds", "zenoh", "zenoh-router")
TOPICS = 5
FITTED, CHECKED = (2, 4, 8), 12
JOINED = 3.0
SEARCH = {"dds": 32.0}
"""Seconds for which a new process of an engine looks for others at all ports of the machine."""
IDLE = 10.0
READERS = (1, 2, 4, 8)
SAMPLES = 2000


def serve(address: str, place: int, count: int) -> None:
    """Run one process with its topics and those of its neighbour; print the number of samples."""
    medium = medium_at(address)
    came = [0]
    publishers = [
        medium.publisher(Topic(f"{place}/{k}", rtc.TimedPose2D), Qos(depth=8))
        for k in range(TOPICS)
    ]

    def on_sample(_: object) -> None:
        came[0] += 1

    for k in range(TOPICS):
        topic = Topic(f"{(place + 1) % count}/{k}", rtc.TimedPose2D)
        medium.subscribe(topic, Qos(depth=8), on_sample)
    medium.subscribe(Topic("all", rtc.TimedPose2D), Qos(depth=None), on_sample)
    deadline = time.monotonic() + 30
    while count > 1 and not all(p.matched for p in publishers):
        if time.monotonic() > deadline:
            break
        time.sleep(0.02)
    print("ready", flush=True)
    for _ in sys.stdin:
        print(came[0], flush=True)
    medium.close()


def octets() -> int:
    """Return the number of octets received by the loopback interface."""
    for line in Path("/proc/net/dev").read_text().splitlines():
        name, _, rest = line.partition(":")
        if name.strip() == "lo":
            return int(rest.split()[0])
    raise SystemExit("there is no interface lo")


def used(pid: int) -> tuple[float, float]:
    """Return memory in MiB and processor time in s."""
    status = Path(f"/proc/{pid}/status").read_text()
    memory = next(
        int(x.split()[1]) for x in status.splitlines() if x.startswith("VmRSS")
    )
    fields = Path(f"/proc/{pid}/stat").read_text().rpartition(")")[2].split()
    return memory / 1024, (int(fields[11]) + int(fields[12])) / os.sysconf("SC_CLK_TCK")


def measured(name: str, count: int) -> dict[str, float]:
    """Return octets to join and in an idle second; memory and processor time of a process."""
    with ExitStack() as stack:
        network = stack.enter_context(engine(name))
        first = network.medium() if name == "zenoh" else None
        if first is not None:
            stack.callback(first.close)
        before = octets()
        processes = started(stack, str(network.address), count)
        time.sleep(JOINED)
        joined = octets() - before
        time.sleep(SEARCH.get(name, 0.0))
        pids = [p.pid for p in processes]
        times, begun, quiet = [used(p)[1] for p in pids], time.monotonic(), octets()
        time.sleep(IDLE)
        seconds = time.monotonic() - begun
        idle = (octets() - quiet) / seconds
        now = [used(pid) for pid in pids]
        processor = statistics.mean(
            (b[1] - a) / seconds for a, b in zip(times, now, strict=True)
        )
        memory = statistics.mean(m for m, _ in now)
        return {
            "joined": joined,
            "idle": idle,
            "memory": memory,
            "processor": processor,
        }


def fan_out(name: str, readers: int) -> float:
    """Return samples per second of a writer that all readers receive."""
    with ExitStack() as stack:
        network = stack.enter_context(engine(name))
        medium = network.medium()
        stack.callback(medium.close)
        processes = started(stack, str(network.address), readers)
        publisher = medium.publisher(
            Topic("all", rtc.TimedPose2D), Qos(depth=None, patience=60)
        )
        while not publisher.matched:
            time.sleep(0.02)
        time.sleep(1)
        encode = encoder(rtc.TimedPose2D)
        sample = rtc.TimedPose2D()
        begun = time.perf_counter()
        for _ in range(SAMPLES):
            publisher.publish(encode(sample))
        while any(asked(p) < SAMPLES for p in processes):
            if time.perf_counter() - begun > 60:
                break
        return SAMPLES / (time.perf_counter() - begun)


def asked(process: subprocess.Popen[str]) -> int:
    """Return the number of samples received."""
    assert process.stdin is not None
    assert process.stdout is not None
    process.stdin.write("\n")
    process.stdin.flush()
    return int(process.stdout.readline())


def started(stack: ExitStack, address: str, count: int) -> list[subprocess.Popen[str]]:
    """Start the processes; return them once each has discovered its neighbours."""
    made = []
    for place in range(count):
        command = [sys.executable, __file__, "--serve", address, str(place), str(count)]
        process = subprocess.Popen(
            command, stdin=subprocess.PIPE, stdout=subprocess.PIPE, text=True
        )
        stack.callback(ended, process)
        made.append(process)
    for process in made:
        assert process.stdout is not None
        process.stdout.readline()
    return made


def ended(process: subprocess.Popen[str]) -> None:
    """End a process."""
    try:
        process.communicate(timeout=20)
    except subprocess.TimeoutExpired:
        process.kill()
        process.communicate()


def constants(table: Table, name: str) -> Constants:
    """Measure an engine, add the figures, and fit the constants."""
    rows = {count: measured(name, count) for count in (*FITTED, CHECKED)}
    for count, row in rows.items():
        traffic = row["joined"] / 1024, row["idle"] / 1024
        table.add(f"{name}, {count}", *traffic, row["memory"], row["processor"])
    found = {
        key: fitted([(n, rows[n][key]) for n in FITTED]) for key in ("joined", "idle")
    }
    for key, (one, pair) in found.items():
        guess = one * CHECKED + pair * CHECKED * (CHECKED - 1) / 2
        print(
            f"  {key}: {one:.0f} and {pair:.0f}; at {CHECKED} {guess / rows[CHECKED][key]:.2f}"
        )
    least, most = rows[FITTED[0]]["memory"], rows[CHECKED]["memory"]
    growth = max(0.0, (most - least) / (CHECKED - FITTED[0]))
    rates = " ".join(f"{n}:{fan_out(name, n):.0f}" for n in READERS)
    print(f"  samples/s that all of N readers get: {rates}")
    return Constants(*found["joined"], *found["idle"], least, growth)


def fill(table: Table, fleets: tuple[int, ...], found: dict[str, Constants]) -> None:
    """Fill the table of fleets."""
    for robots in fleets:
        fleet = Fleet(robots)
        rows = []
        for name, c in found.items():
            if name != "zenoh-router":
                rows.append((f"{name}, flat", flat(fleet, c), ""))
            if name == "dds":
                rows.append(
                    ("dds, a domain for each robot", by_robot(fleet, c), " by robot")
                )
            if name == "zenoh-router":
                sites, links = by_site(fleet, c)
                rows.append(
                    (
                        "zenoh, a router for 250 robots",
                        sites[0],
                        f" by site, {links} links",
                    )
                )
        for title, load, note in rows:
            traffic = load.joined / 2**20, load.idle / 1024
            most = load.most_sessions, load.most_memory
            table.add(f"{robots:,}, {title}{note}", *traffic, *most)


def main() -> None:
    """Print the tables of the engines and of fleets."""
    parser = Arguments(__doc__, rounds=1)
    parser.add_argument("engines", nargs="*")
    chosen = parser.parse_args()
    names = ("zenoh",) if chosen.smallest else chosen.engines or ENGINES
    with Results(__file__, chosen) as results:
        table = results.table(
            "engines",
            "engine, processes",
            ("to join [KiB]", ",.0f"),
            ("idle [KiB/s]", ",.2f"),
            ("memory of one [MiB]", ".0f"),
            ("of a processor", ".2%"),
        )
        found = {name: constants(table, name) for name in names}
        table = results.table(
            "fleets",
            "robots of 3 processes",
            ("to join [MiB]", ",.1f"),
            ("idle [KiB/s]", ",.1f"),
            ("sessions of the busiest", ",d"),
            ("its memory [MiB]", ",.0f"),
        )
        fill(table, (10, 1_000, 100_000), found)


if __name__ == "__main__":
    if sys.argv[1:2] == ["--serve"]:
        serve(sys.argv[2], int(sys.argv[3]), int(sys.argv[4]))
    else:
        main()
