"""CDR of small messages: rtgen's codecs compared with omniORBpy, cyclonedds, protobuf, msgpack.

    python benchmarks/cdr.py

Rounds of all candidates are interleaved; the least processor time is printed, in nanoseconds, with
its ratio to ours. Values are built beforehand for omniORBpy, cyclonedds and msgspec's msgpack,
which takes the same objects; against protobuf both sides build and serialize, or parse and read
every field. Types with sequences are given with the numbers of their items.
"""

from __future__ import annotations

import importlib
import sys
import tempfile
import time
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from pathlib import Path
from types import SimpleNamespace
from typing import Any

from cdr_peers import (
    OWN,
    SPECS,
    CycloneDds,
    Protobuf,
    Texts,
    load_omniorb,
    omniorb_type,
    omniorb_value,
)
from tables import Arguments, Results, Table

ROUNDS = 25
SECONDS_PER_ROUND = 0.004

Task = Callable[[], object]


@dataclass(frozen=True)
class Case:
    """The tasks of one candidate: encode and decode."""

    name: str
    encode: Task
    decode: Task


def generated(folder: Path) -> Any:
    """Return the generated packages."""
    from rtgen.compiler.backends import Options
    from rtgen.compiler.backends.types.backend import BACKEND
    from rtgen.compiler.frontends.idl import load
    from rtgen.compiler.lowering.numeric import lower
    from rtgen.compiler.lowering.settings import Settings

    result = load([OWN], root=OWN.parent, include=[SPECS])
    model = lower(result.model, Settings(numeric="array")).model
    for artifact in BACKEND.emit(model, Options("bench_types", "s", "0")).artifacts:
        path = folder / artifact.path
        path.parent.mkdir(parents=True, exist_ok=True)
        path.write_text(artifact.text, encoding="utf-8")
    sys.path.insert(0, str(folder))
    names = ("rtc", "iis", "bench")
    found = {name: importlib.import_module(f"bench_types.{name}") for name in names}
    return SimpleNamespace(**found)


def values(types: Any) -> Iterator[tuple[str, Any]]:
    """Yield a title and a value for each measurement."""
    rtc, iis, bench = types.rtc, types.iis, types.bench
    tm, point = rtc.Time(1, 2), rtc.Point2D(1.0, 2.0)
    pose, velocity = rtc.Pose2D(point, 0.5), rtc.Velocity2D(0.3, 0.0, 0.1)
    yield "RTC::TimedPose2D", rtc.TimedPose2D(tm, pose)
    yield "RTC::TimedVelocity2D", rtc.TimedVelocity2D(tm, velocity)
    for ids, errors in ((0, 0), (1, 3), (16, 36)):
        identifiers, numbers = [*range(ids)], [i / 7 for i in range(errors)]
        lengths = f"{ids}/{errors}"
        value = iis.TimedPose2D(tm, identifiers, pose, numbers)
        yield f"IIS::TimedPose2D {lengths}", value
        value = iis.TimedVelocity2D(tm, identifiers, velocity, numbers)
        yield f"IIS::TimedVelocity2D {lengths}", value
    yield "RTC::RangeData 360", rtc.RangeData(tm, [i / 7 for i in range(360)])
    reading, report = bench.Reading, bench.Report
    place = reading(bench.Kind.POINT, point)
    text = reading(bench.Kind.TEXT, "bumper")
    first, second = report(1, place), report(9, "stopped")
    yield "nested unions", bench.Event(tm, first, second, text)
    tags = ["laser", "indoor", "class 1"]
    texts = ["Maker Inc.", "LX-30", "00012345", "1.4.2", "Scanner, " * 8, tags]
    yield "strings", bench.Device(*texts)


def cases(value: Any, cyclone: CycloneDds, protobuf: Protobuf) -> list[Case]:
    """Return all candidates for a value."""
    import msgspec
    import omniORB

    type_ = type(value)
    described = type_._descriptor_
    octets, second = value.to_cdr(), value.to_xcdr2()
    from_cdr, from_xcdr2 = type_.from_cdr, type_.from_xcdr2
    texts = Texts({"from_cdr": from_cdr})
    fields = ", ".join(texts.read(described, value, "made", False))
    read = texts.function("made", f"({fields},)")
    theirs = omniorb_value(described, value)
    code = omniorb_type(described)
    marshal, unmarshal = omniORB.cdrMarshal, omniORB.cdrUnmarshal
    body = marshal(code, theirs, 1)
    assert len(body) == len(octets)
    sample = cyclone.value(described, value)
    plain1, plain2 = sample.serialize(), sample.serialize(use_version_2=True)
    assert plain1[4:] == octets, (plain1[4:], octets)
    packed = msgspec.msgpack.encode(value)
    unions = "Union" in str(described)
    unpack = msgspec.msgpack.Decoder(Any if unions else type_).decode
    pack = msgspec.msgpack.Encoder().encode
    classes = protobuf.classes
    message = classes[described.name.replace("::", "_")]
    make = texts.function("", texts.theirs(described, value, classes))
    parts = ", ".join(texts.read(described, value, "made", True))
    parse = texts.function("made", f"({parts},)")
    wire = make().SerializeToString()
    build = texts.function("", texts.ours(described, value))
    assert build() == value
    return [
        Case("rtgen", value.to_cdr, lambda: from_cdr(octets)),
        Case(
            "omniORBpy (C++)",
            lambda: marshal(code, theirs, 1),
            lambda: unmarshal(code, body, 1),
        ),
        Case(
            f"msgspec msgpack{', untyped' * unions}",
            lambda: pack(value),
            lambda: unpack(packed),
        ),
        Case("cyclonedds", sample.serialize, lambda: type(sample).deserialize(plain1)),
        Case("rtgen, XCDR2", value.to_xcdr2, lambda: from_xcdr2(second)),
        Case(
            "cyclonedds, XCDR2",
            lambda: sample.serialize(use_version_2=True),
            lambda: type(sample).deserialize(plain2),
        ),
        Case(
            "rtgen, built and read",
            lambda: build().to_cdr(),
            lambda: read(from_cdr(octets)),
        ),
        Case(
            protobuf.name,
            lambda: make().SerializeToString(),
            lambda: parse(message.FromString(wire)),
        ),
    ]


def least_times(tasks: list[Task], rounds: int = ROUNDS) -> list[float]:
    """Return nanoseconds of processor time of each task: the least of interleaved rounds."""
    clock = time.process_time_ns
    numbers = []
    for task in tasks:
        start, count = clock(), 0
        while clock() - start < SECONDS_PER_ROUND * 1e9:
            task()
            count += 1
        numbers.append(max(count, 1))
    samples: list[list[float]] = [[] for _ in tasks]
    for _ in range(rounds):
        for task, number, times in zip(tasks, numbers, samples, strict=True):
            repeat = range(number)
            start = clock()
            for _ in repeat:
                task()
            times.append((clock() - start) / number)
    return [min(times) for times in samples]


def report(table: Table, rounds: int, title: str, all_cases: list[Case]) -> None:
    """Fill the table with the cases of a value."""
    encode = least_times([case.encode for case in all_cases], rounds)
    decode = least_times([case.decode for case in all_cases], rounds)
    base = 0
    for place, case in enumerate(all_cases):
        if case.name.startswith("rtgen"):
            base = place
        both = encode, decode
        pairs = [(times[place], times[place] / times[base]) for times in both]
        table.add(f"{title}, {case.name}", *(n for pair in pairs for n in pair))


def main() -> None:
    """Print times and ratios (the other's time over rtgen's) for each value."""
    parser = Arguments(__doc__, rounds=ROUNDS)
    parser.add_argument("titles", nargs="*", help="parts of the titles of values")
    chosen = parser.parse_args()
    with (
        Results(__file__, chosen) as results,
        tempfile.TemporaryDirectory() as one,
        tempfile.TemporaryDirectory() as two,
    ):
        types = generated(Path(one))
        load_omniorb(Path(two), OWN)
        found = list(values(types))
        cyclone = CycloneDds()
        protobuf = Protobuf([type(value)._descriptor_ for _, value in found])
        table = results.table(
            "small",
            "value",
            ("encode [ns]", ".0f"),
            ("ratio", ".2f"),
            ("decode [ns]", ".0f"),
            ("ratio", ".2f"),
        )
        for title, value in found[:1] if chosen.smallest else found:
            if chosen.titles and not any(word in title for word in chosen.titles):
                continue
            report(table, chosen.rounds, title, cases(value, cyclone, protobuf))


if __name__ == "__main__":
    main()
