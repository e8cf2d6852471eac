"""CDR of TimedPose2D: our generated codec beside cyclonedds-python, protobuf and omniORBpy.

    python benchmarks/cdr.py

Rounds of all candidates are interleaved; the least processor time is printed, in nanoseconds, with
its ratio to ours. Values are built beforehand for omniORBpy and cyclonedds; against protobuf both
sides build and serialize, or parse and read every field. Lengths are those of `id` and `error`.
"""

from __future__ import annotations

import importlib
import shutil
import subprocess
import sys
import sysconfig
import tempfile
import time
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from typing import Any

SPECS = Path(__file__).resolve().parents[1] / "specs" / "idl"
LENGTHS = ((0, 0), (1, 3), (16, 36))
ROUNDS = 25
SECONDS_PER_ROUND = 0.004

Task = Callable[[], object]


@dataclass(frozen=True)
class Case:
    """The tasks of one candidate: encode and decode, and what ours is for the comparison."""

    name: str
    encode: Task
    decode: Task


def ours(folder: Path) -> tuple[Any, Any]:
    """The generated packages `rtc` and `iis`."""
    from rtgen.backends import Options
    from rtgen.backends.types import BACKEND
    from rtgen.frontends.idl import load

    result = load([SPECS / "intellirobot.idl"], root=SPECS)
    emission = BACKEND.emit(result.model, Options("bench_types", "skeletons", "0"))
    for artifact in emission.artifacts:
        path = folder / artifact.path
        path.parent.mkdir(parents=True, exist_ok=True)
        path.write_text(artifact.text, encoding="utf-8")
    sys.path.insert(0, str(folder))
    return (
        importlib.import_module("bench_types.rtc"),
        importlib.import_module("bench_types.iis"),
    )


def our_cases(folder: Path) -> Callable[[int, int], list[Case]]:
    rtc, iis = ours(folder)

    def cases(ids: int, errors: int) -> list[Case]:
        identifiers, numbers = list(range(ids)), [i / 7 for i in range(errors)]
        pose = rtc.Pose2D(rtc.Point2D(1.0, 2.0), 0.5)
        value = iis.TimedPose2D(rtc.Time(1, 2), identifiers, pose, numbers)
        octets = value.to_cdr()
        from_cdr = iis.TimedPose2D.from_cdr

        def build() -> bytes:
            point = rtc.Point2D(1.0, 2.0)
            made = iis.TimedPose2D(
                rtc.Time(1, 2), identifiers, rtc.Pose2D(point, 0.5), numbers
            )
            return bytes(made.to_cdr())

        def read() -> object:
            made = from_cdr(octets)
            tm, data = made.tm, made.data
            position = data.position
            return (
                tm.sec,
                tm.nsec,
                list(made.id),
                position.x,
                position.y,
                data.heading,
                list(made.error),
            )

        second = value.to_xcdr2()
        from_xcdr2 = iis.TimedPose2D.from_xcdr2
        return [
            Case("rtgen", value.to_cdr, lambda: from_cdr(octets)),
            Case("rtgen, XCDR2", value.to_xcdr2, lambda: from_xcdr2(second)),
            Case("rtgen, built and read", build, read),
        ]

    return cases


def cyclone_cases() -> Callable[[int, int], list[Case]]:
    from cyclonedds_types import Point2D, Pose2D, Time, TimedPose2D

    def cases(ids: int, errors: int) -> list[Case]:
        value = TimedPose2D(
            Time(1, 2),
            list(range(ids)),
            Pose2D(Point2D(1.0, 2.0), 0.5),
            [i / 7 for i in range(errors)],
        )
        octets = value.serialize()
        second = value.serialize(use_version_2=True)
        return [
            Case(
                "cyclonedds", value.serialize, lambda: TimedPose2D.deserialize(octets)
            ),
            Case(
                "cyclonedds, XCDR2",
                lambda: value.serialize(use_version_2=True),
                lambda: TimedPose2D.deserialize(second),
            ),
        ]

    return cases


def protobuf_case() -> Callable[[int, int], Case]:
    from google.protobuf import descriptor_pb2, descriptor_pool, message_factory
    from google.protobuf.internal import api_implementation

    file = descriptor_pb2.FileDescriptorProto(
        name="b.proto", package="b", syntax="proto3"
    )
    kinds = descriptor_pb2.FieldDescriptorProto

    def message(name: str, *fields: tuple[str, int, str, bool]) -> None:
        made = file.message_type.add(name=name)
        for number, (field, kind, type_name, repeated) in enumerate(fields, 1):
            label = kinds.LABEL_REPEATED if repeated else kinds.LABEL_OPTIONAL
            added = made.field.add(name=field, number=number, type=kind, label=label)
            if type_name:
                added.type_name = type_name

    double, nested = kinds.TYPE_DOUBLE, kinds.TYPE_MESSAGE
    message(
        "Time",
        ("sec", kinds.TYPE_FIXED32, "", False),
        ("nsec", kinds.TYPE_FIXED32, "", False),
    )
    message("Point2D", ("x", double, "", False), ("y", double, "", False))
    message(
        "Pose2D",
        ("position", nested, ".b.Point2D", False),
        ("heading", double, "", False),
    )
    message(
        "TimedPose2D",
        ("tm", nested, ".b.Time", False),
        ("id", kinds.TYPE_INT32, "", True),
        ("data", nested, ".b.Pose2D", False),
        ("error", double, "", True),
    )
    pool = descriptor_pool.DescriptorPool()
    pool.Add(file)
    found = message_factory.GetMessageClassesForFiles(["b.proto"], pool)
    time_, point = found["b.Time"], found["b.Point2D"]
    pose, timed = found["b.Pose2D"], found["b.TimedPose2D"]
    name = f"protobuf ({api_implementation.Type()})"

    def case(ids: int, errors: int) -> Case:
        identifiers, numbers = list(range(ids)), [i / 7 for i in range(errors)]

        def build() -> bytes:
            made = timed(
                tm=time_(sec=1, nsec=2),
                id=identifiers,
                data=pose(position=point(x=1.0, y=2.0), heading=0.5),
                error=numbers,
            )
            return bytes(made.SerializeToString())

        octets = build()

        def read() -> object:
            made = timed.FromString(octets)
            tm, data = made.tm, made.data
            position = data.position
            return (
                tm.sec,
                tm.nsec,
                list(made.id),
                position.x,
                position.y,
                data.heading,
                list(made.error),
            )

        return Case(name, build, read)

    return case


def omniorb_case(folder: Path) -> Callable[[int, int], Case]:
    import omniORB
    from omniORB import CORBA

    scripts = sysconfig.get_path("scripts")
    omniidl = shutil.which("omniidl", path=scripts) or "omniidl"
    for name in ("BasicDataType", "ExtendedDataTypes", "intellirobot"):
        source = str(SPECS / f"{name}.idl")
        subprocess.run(
            [omniidl, "-bpython", f"-I{SPECS}", f"-C{folder}", source], check=True
        )
    CORBA.ORB_init(["bench", "-ORBnativeCharCodeSet", "UTF-8"])
    sys.path.insert(0, str(folder))
    rtc, iis = importlib.import_module("RTC"), importlib.import_module("IIS")

    def case(ids: int, errors: int) -> Case:
        code = iis._tc_TimedPose2D
        value = iis.TimedPose2D(
            rtc.Time(1, 2),
            list(range(ids)),
            rtc.Pose2D(rtc.Point2D(1.0, 2.0), 0.5),
            [i / 7 for i in range(errors)],
        )
        octets = omniORB.cdrMarshal(code, value, 1)
        marshal, unmarshal = omniORB.cdrMarshal, omniORB.cdrUnmarshal
        return Case(
            "omniORBpy (C++)",
            lambda: marshal(code, value, 1),
            lambda: unmarshal(code, octets, 1),
        )

    return case


def least_times(tasks: list[Task]) -> list[float]:
    """Nanoseconds of processor time of each task: the least of interleaved rounds."""
    clock = time.process_time_ns
    numbers = []
    for task in tasks:
        start, count = clock(), 0
        while clock() - start < SECONDS_PER_ROUND * 1e9:
            task()
            count += 1
        numbers.append(max(count, 1))
    samples: list[list[float]] = [[] for _ in tasks]
    for _ in range(ROUNDS):
        for task, number, times in zip(tasks, numbers, samples, strict=True):
            repeat = range(number)
            start = clock()
            for _ in repeat:
                task()
            times.append((clock() - start) / number)
    return [min(times) for times in samples]


def report(what: str, cases: list[Case], tasks: list[Task]) -> None:
    times = least_times(tasks)
    ours = dict(zip((case.name for case in cases), times, strict=True))
    for case, taken in zip(cases, times, strict=True):
        base = ours["rtgen"]
        if case.name.startswith("protobuf"):
            base = ours["rtgen, built and read"]
        elif case.name.endswith("XCDR2"):
            base = ours["rtgen, XCDR2"]
        print(f"  {what:7} {case.name:24} {taken:9.0f} ns  {taken / base:6.2f}")


def main() -> None:
    """Prints times and ratios (the other's time over ours) for each pair of lengths."""
    with tempfile.TemporaryDirectory() as one, tempfile.TemporaryDirectory() as two:
        mine = our_cases(Path(one))
        cyclone = cyclone_cases()
        peers = [protobuf_case(), omniorb_case(Path(two))]
        print("time, and its ratio to ours in the same representation;")
        print("protobuf's to ours built and read")
        for ids, errors in LENGTHS:
            cases = [*mine(ids, errors), *cyclone(ids, errors)]
            cases += [peer(ids, errors) for peer in peers]
            print(f"TimedPose2D {ids}/{errors}")
            report("encode", cases, [case.encode for case in cases])
            report("decode", cases, [case.decode for case in cases])


if __name__ == "__main__":
    main()
