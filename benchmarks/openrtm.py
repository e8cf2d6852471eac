"""OpenRTM: conversions compared with omniORBpy's marshalling, connections with OpenRTM's own.

    python benchmarks/openrtm.py [--all]

Conversions: for each type of OpenRTM and of the reference build, the time to fill the reused wire
object of an OutPort relative to its cdrMarshal, and to make a value of a wire object relative to
its cdrUnmarshal. Rounds of all tasks alternate, on one processor, whose time is measured; the
medians are compared. Sequences have 0, 4 and 64 items. The output has the types with the highest
ratios, with `--all` each type; beside them a new wire object (`to`, for service calls and
`direct` connectors). Limits: 1.0 outgoing, 1.2 incoming.

Connections: samples by `corba_cdr` between two processes, from and to the runtime (as `rtgen run
--transport corba`) and OpenRTM-aist-Python (see `openrtm_ends.py`), if that is installed. Rounds of
the four connections alternate; the result is the median of the ratios to OpenRTM with itself in the
same round. Limit: 1.0 for the processor time of both ends for a sample.

The exit code is 1 if a ratio is above its limit.
"""

from __future__ import annotations

import importlib
import importlib.util
import json
import math
import os
import statistics
import subprocess
import sys
import tempfile
import time
from collections.abc import Callable, Iterator
from contextlib import ExitStack
from dataclasses import dataclass
from itertools import islice
from pathlib import Path
from typing import Any

from openrtm_ends import SIDES, TYPES
from tables import Arguments, Results, Table

ROOT = Path(__file__).resolve().parents[1]
DEFINITIONS = (".idl", ".cdl", ".eds", ".toml")
LENGTHS = (0, 4, 64)
LIMITS = (1.0, 1.2)
ROUNDS = 11
SECONDS_PER_ROUND = 0.001
SHOWN = 12
BATCHES = {"TimedPose2D": (500, 0.002), "TimedDoubleSeq": (6, 0.08)}
"""Number of samples of a batch, and the pause [s] before each if latency is measured."""
KINDS = ("sample", "processor", "latency")
LATENCY_DIVISOR = 5
"""Divisor of the number of samples if latency is measured."""

Task = Callable[[], object]


@dataclass(frozen=True)
class Case:
    """A value of a type: its name, and the five tasks."""

    name: str
    tasks: tuple[Task, Task, Task, Task, Task]


@dataclass(frozen=True)
class Result:
    """Medians in ns: filled, marshalled, made of, unmarshalled, made new.

    A wchar has no unmarshalling time: omniORBpy 4.3.3 cannot read what it wrote.
    """

    name: str
    times: tuple[float, ...]

    @property
    def ratios(self) -> tuple[float, float, float]:
        filled, marshalled, made, unmarshalled, new = self.times
        return filled / marshalled, made / unmarshalled, new / marshalled


def generate(folder: Path) -> list[str]:
    """Generate the reference build for OpenRTM, and its stubs; return their names."""
    specs = ROOT / "specs"
    files = [str(p) for p in sorted(specs.glob("*/*")) if p.suffix in DEFINITIONS]
    command = [sys.executable, "-m", "rtgen", "generate", *files, "-q"]
    told = ["--target", "openrtm", "-o", str(folder), "--no-cache"]
    subprocess.run([*command, *told], cwd=ROOT, check=True, stderr=subprocess.DEVNULL)
    idl = {p.stem: p for p in (folder / "generated").glob("openrtm/*/idl/*.idl")}
    idl |= {p.stem: p for p in (specs / "idl").glob("*.idl")}
    together = folder / "idl"
    together.mkdir()
    for stem, path in idl.items():
        (together / f"{stem}.idl").write_bytes(path.read_bytes())
    stubs = folder / "stubs"
    stubs.mkdir()
    omniidl = Path(sys.executable).with_name("omniidl")
    command = [str(omniidl), "-bpython", f"-I{together}", f"-C{stubs}"]
    subprocess.run([*command, *map(str, sorted(together.iterdir()))], check=True)
    return sorted(idl)


def structs(folder: Path) -> Iterator[type[Any]]:
    """Yield rtgen's classes of structs that omniORB knows."""
    import omniORB

    for file in sorted((folder / "generated").rglob("_idl/[a-z]*.py")):
        if file.stem.endswith("_calls"):
            continue
        package = ".".join(file.parent.parent.relative_to(folder / "generated").parts)
        types = importlib.import_module(f"{package}._idl.{file.stem}")
        for value in vars(types).values():
            own = isinstance(value, type) and value.__module__ == types.__name__
            is_value = own and hasattr(value, "_snapshot_")
            if is_value and omniORB.findType(value._descriptor_.repository_id):
                yield value


def example(descriptor: Any, types: dict[str, type[Any]], length: int) -> Any:
    """Return a value of the type whose sequences have that many items."""
    from rtgen.runtime.marshalling.descriptors import (
        ArrayDescriptor,
        EnumDescriptor,
        PrimitiveDescriptor,
        SequenceDescriptor,
        StringDescriptor,
        StructDescriptor,
        UnionDescriptor,
        plain,
    )

    descriptor = plain(descriptor)
    match descriptor:
        case StructDescriptor(members=members):
            made = (example(m.type, types, length) for m in members)
            return types[descriptor.repository_id](*made)
        case UnionDescriptor():
            return types[descriptor.repository_id]()
        case EnumDescriptor():
            return list(types[descriptor.repository_id])[-1]
        case StringDescriptor():
            return "robot"
        case SequenceDescriptor(element, bound):
            count = length if bound is None else min(length, bound)
            return joined(
                [example(element, types, length) for _ in range(count)], element
            )
        case ArrayDescriptor(element, (first, *rest)):
            inner = ArrayDescriptor(element, tuple(rest)) if rest else element
            return joined([example(inner, types, length) for _ in range(first)], inner)
        case PrimitiveDescriptor("boolean"):
            return True
        case PrimitiveDescriptor("char" | "wchar"):
            return "r"
        case PrimitiveDescriptor("float" | "double"):
            return 0.75
        case PrimitiveDescriptor(name) if name not in ("any", "Object"):
            return 7
    return default(descriptor)


def default(descriptor: Any) -> Any:
    """Return the initial value of a class."""
    from rtgen.runtime.values import AnyValue

    return AnyValue() if getattr(descriptor, "name", "") == "any" else None


def joined(items: list[Any], element: Any) -> Any:
    """Return the items as `bytes` or `str` if such a sequence is represented so."""
    from rtgen.runtime.marshalling.descriptors import plain

    name = getattr(plain(element), "name", "")
    if name in ("octet", "uint8"):
        return bytes(items)
    return "".join(items) if name == "char" else items


def cases(folder: Path) -> Iterator[Case]:
    """Yield every struct, with sequences of all lengths."""
    import omniORB

    known = list(structs(folder))
    types = {
        value._descriptor_.repository_id: value
        for kind in known
        for value in vars(sys.modules[kind.__module__]).values()
        if isinstance(value, type) and hasattr(value, "_descriptor_")
    }
    for kind in known:
        code = omniORB.findTypeCode(kind._descriptor_.repository_id)
        seen = set()
        for length in LENGTHS:
            value = example(kind._descriptor_, types, length)
            octets = value.to_cdr()
            if octets in seen:
                continue
            seen.add(octets)
            name = kind._descriptor_.name + (f", {length}" if len(seen) > 1 else "")
            yield Case(name, tasks(kind, code, value))


def nothing() -> None:
    """Do nothing, for a task that cannot be measured."""


def tasks(kind: type[Any], code: Any, value: Any) -> Any:
    """Return the five tasks of a value."""
    import omniORB

    from rtgen.runtime.openrtm.conversions import conversions_of

    conversions = conversions_of(kind._descriptor_)
    fill, to, of = conversions.fill, conversions.to, conversions.of
    marshal, unmarshal = omniORB.cdrMarshal, omniORB.cdrUnmarshal
    kept = to(kind())
    fill(kept, value)
    octets = marshal(code, kept, 1)
    has_wchar = "wchar" in repr(kind._descriptor_)
    arrived = to(value) if has_wchar else unmarshal(code, octets, 1)
    assert of(arrived) == value
    return (
        lambda: fill(kept, value),
        lambda: marshal(code, kept, 1),
        lambda: of(arrived),
        nothing if has_wchar else lambda: unmarshal(code, octets, 1),
        lambda: to(value),
    )


def measured(case: Case, rounds: int) -> Result:
    """Return the medians of rounds that alternate between the tasks."""
    clock = time.process_time_ns
    numbers = []
    for task in case.tasks:
        start, count = clock(), 0
        while clock() - start < SECONDS_PER_ROUND * 1e9:
            task()
            count += 1
        numbers.append(max(count, 1))
    samples: list[list[float]] = [[] for _ in case.tasks]
    for _ in range(rounds):
        for task, number, times in zip(case.tasks, numbers, samples, strict=True):
            repeat = range(number)
            start = clock()
            for _ in repeat:
                task()
            times.append((clock() - start) / number)
    medians = [statistics.median(times) for times in samples]
    if case.tasks[3] is nothing:
        medians[3] = math.inf
    return Result(case.name, tuple(medians))


def fill(table: Table, results: list[Result]) -> None:
    """Fill a table with times in ns and ratios, a line for each result."""
    for result in results:
        filled, marshalled, made, unmarshalled, new = result.times
        out, into, fresh = result.ratios
        outgoing, incoming = (filled, marshalled, out), (made, unmarshalled, into)
        table.add(result.name, *outgoing, *incoming, new, fresh)


class End:
    """A process of `openrtm_ends.py`."""

    def __init__(self, side: str, kind: str, names: str) -> None:
        script = str(Path(__file__).with_name("openrtm_ends.py"))
        command = [sys.executable, script, side, kind, names]
        pipe = subprocess.PIPE
        self._process = subprocess.Popen(command, stdin=pipe, stdout=pipe, text=True)

    def ask(self, *words: object) -> Any:
        """Send a command; return its answer."""
        assert self._process.stdin is not None
        print(*words, file=self._process.stdin, flush=True)
        return self.answer()

    def answer(self) -> Any:
        """Return the next line."""
        assert self._process.stdout is not None
        line = self._process.stdout.readline()
        assert line, "a process has ended"
        return json.loads(line)

    def close(self) -> None:
        """End the process."""
        assert self._process.stdin is not None
        self._process.stdin.close()
        self._process.wait()


def batch(ends: dict[str, End], way: tuple[str, str], type_: str) -> tuple[float, ...]:
    """Return times of a sample in us: in a row, of the processor, from the write to the reader."""
    sender, receiver = ends[f"{way[0]} Sender"], ends[f"{way[1]} Receiver"]
    there, here = f"{type_}_{way[1]}", f"{type_}_{way[0]}"
    times = []
    count, pause = BATCHES[type_]
    for number, wait in ((count, 0), (max(2, count // LATENCY_DIVISOR), pause)):
        receiver.ask("receive", here, number)
        begun, sending = sender.ask("send", there, number, wait)
        ended, reading, late = receiver.answer()
        times += [(ended - begun) / number, (sending + reading) / number]
    return times[0] / 1e3, times[1] / 1e3, statistics.median(late) / 1e3


def connections(table: Table, names: str, rounds: int) -> bool:
    """Fill the table of the connections; return whether all are within the limit."""
    ways = [(source, target) for source in SIDES for target in SIDES]
    found: dict[tuple[str, tuple[str, str]], list[tuple[float, ...]]] = {}
    with ExitStack() as closing:
        ends: dict[str, End] = {}
        for side in SIDES:
            for kind in ("Sender", "Receiver"):
                end = ends[f"{side} {kind}"] = End(side, kind, names)
                closing.callback(end.close)
        for end in ends.values():
            end.answer()
        for source, target in ways:
            for type_ in TYPES:
                instances = f"{source}Sender0", f"{target}Receiver0"
                ports = f"{type_}_{target}", f"{type_}_{source}"
                [told] = ends["openrtm Sender"].ask("connect", *instances, *ports)
                assert told == "RTC_OK", told
        for _ in range(rounds + 1):
            for type_ in TYPES:
                for way in ways:
                    found.setdefault((type_, way), []).append(batch(ends, way, type_))
    good = True
    for (type_, way), times in found.items():
        row: list[float] = []
        for place in range(len(KINDS)):
            own = [each[place] for each in times[1:]]
            first = [each[place] for each in found[type_, ways[0]][1:]]
            ratio = statistics.median(a / b for a, b in zip(own, first, strict=True))
            good &= ratio <= 1.0 or KINDS[place] != "processor"
            row += [statistics.median(own), ratio]
        each = statistics.median(row[0] for row in times[1:])
        table.add(f"{type_} from {way[0]} to {way[1]}", *row, 1e6 / each)
    return good


def main() -> int:
    """Print the tables; return 1 if a ratio is above its limit."""
    parser = Arguments(__doc__, rounds=ROUNDS)
    parser.add_argument("--all", action="store_true", help="each type")
    chosen = parser.parse_args()
    if hasattr(os, "sched_setaffinity"):
        os.sched_setaffinity(0, {max(os.sched_getaffinity(0))})
    good = True
    if importlib.util.find_spec("OpenRTM_aist") is None:
        print("Data connections are left out: OpenRTM-aist-Python is not installed")
    with Results(__file__, chosen) as results:
        if importlib.util.find_spec("OpenRTM_aist") is not None:
            from rtgen.runtime.corba.name_server import NameServer

            figures = [
                f for text in KINDS for f in ((f"{text} [µs]", ".0f"), ("ratio", ".2f"))
            ]
            columns = *figures, ("samples/s", ",.0f")
            table = results.table("connections", "connection", *columns)
            with NameServer() as names:
                good = connections(table, names.address, chosen.rounds)
        good &= converted(results, chosen)
    return int(not good and not chosen.smallest)


def converted(tables: Results, chosen: Any) -> bool:
    """Print the tables of the conversions; return whether all are within the limits."""
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        stems = generate(folder)
        sys.path.insert(0, str(folder / "generated"))
        from omniORB import CORBA

        from rtgen.runtime.openrtm import stubs

        CORBA.ORB_init(["bench", "-ORBnativeCharCodeSet", "UTF-8"])
        stubs.load(folder / "stubs", stems)
        every = cases(folder)
        if chosen.smallest:
            every = islice(every, 3)
        results = [measured(case, chosen.rounds) for case in every]
    ways = (
        "outgoing (fill / marshal)",
        "incoming (from / unmarshal)",
        "new (to / marshal)",
    )
    columns = [
        *(("fill [ns]", ".0f"), ("marshal [ns]", ".0f"), ("ratio", ".2f")),
        *(("from [ns]", ".0f"), ("unmarshal [ns]", ".0f"), ("ratio", ".2f")),
        *(("to [ns]", ".0f"), ("ratio", ".2f")),
    ]
    for way in (0, 1):
        ordered = sorted(results, key=lambda r: -r.ratios[way])
        title = f"{ways[way]}: the highest"
        fill(Table("", (title, *columns)), ordered[: None if chosen.all else SHOWN])
    figures = ("values", "d"), ("median", ".2f"), ("highest", ".2f"), ("limit", "g")
    table = tables.table("values", "conversion", *figures)
    for way, text in enumerate(ways):
        ratios = sorted(result.ratios[way] for result in results)
        limit = LIMITS[way] if way < 2 else None
        table.add(text, len(ratios), statistics.median(ratios), ratios[-1], limit)
    return all(r.ratios[way] <= LIMITS[way] for r in results for way in (0, 1))


if __name__ == "__main__":
    raise SystemExit(main())
