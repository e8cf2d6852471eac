"""CDR of large payloads (scans, images, point clouds) compared with copies and other libraries.

    python benchmarks/payload.py

Least processor time of a call in microseconds, rounds interleaved, and its ratio to a copy of the
octets in the same run. Scans of 100 to 1,000,000 doubles are members in each form of numbers in
Python, and arrays in an appendable type in XCDR2. An image is 1 MB of octets, clouds are structs of
four doubles as structured arrays. cyclonedds-python and omniORBpy have lists of numbers and of
objects; cyclonedds-python encodes in the byte order of the machine only.
"""

from __future__ import annotations

import importlib
import re
import sys
import tempfile
from array import array
from collections.abc import Callable, Iterator
from functools import partial
from pathlib import Path
from typing import Any

import numpy
from cdr import least_times
from cdr_peers import CycloneDds, load_omniorb, omniorb_type, omniorb_value
from tables import Arguments, Results, Table

from rtgen.runtime import idl

COUNTS = (100, 1_000, 10_000, 100_000, 1_000_000)
POINTS = (20_000, 100_000)
ORDERS = (("little-endian", True), ("big-endian", False))
IDL = """
module payload {
    struct Scan { long stamp; sequence<double> ranges; };
    struct ListScan { long stamp; @numeric("list") sequence<double> ranges; };
    @appendable struct OpenScan { long stamp; sequence<double> ranges; };
    struct NumpyScan { long stamp; @numeric("numpy") sequence<double> ranges; };
    struct Image { long stamp; sequence<octet> pixels; };
    struct Point { double x; double y; double z; double intensity; };
    struct Cloud { long stamp; long reserved; @numeric("numpy") sequence<Point> points; };
};
"""

Row = tuple[str, Callable[[], object], Callable[[], object]]
"""A title, the encoder, the decoder."""


def generated(folder: Path) -> Any:
    """Return the generated package, and omniORBpy's stubs of the same types."""
    from rtgen.compiler.backends import Options
    from rtgen.compiler.backends.types.backend import BACKEND
    from rtgen.compiler.frontends.idl import load
    from rtgen.compiler.lowering.numeric import lower
    from rtgen.compiler.lowering.settings import Settings

    file = folder / "definitions" / "payload.idl"
    file.parent.mkdir()
    file.write_text(IDL, encoding="utf-8")
    model = load([file], root=file.parent).model
    model = lower(model, Settings(numeric="array")).model
    for artifact in BACKEND.emit(model, Options("bench_payload", "s", "0")).artifacts:
        path = folder / artifact.path
        path.parent.mkdir(parents=True, exist_ok=True)
        path.write_text(artifact.text, encoding="utf-8")
    sys.path.insert(0, str(folder))
    file.write_text(re.sub(r"@\w+(\(.*?\))? ", "", IDL), encoding="utf-8")
    load_omniorb(folder, file)
    return importlib.import_module("bench_payload.payload")


def ours(name: str, value: Any, way: str = "cdr") -> Iterator[Row]:
    """Yield the codecs of both byte orders."""
    encode, decode = getattr(value, f"to_{way}"), getattr(type(value), f"from_{way}")
    for order, little in ORDERS:
        yield (
            f"rtgen, {name}, {order}",
            partial(encode, little),
            partial(decode, encode(little), little),
        )


def peers(value: Any) -> Iterator[Row]:
    """Yield cyclonedds-python and omniORBpy for the same value, of lists."""
    import omniORB

    described = type(value)._descriptor_
    sample = CycloneDds().value(described, value)
    octets = sample.serialize()
    assert octets[4:] == value.to_cdr()
    yield (
        "cyclonedds",
        sample.serialize,
        lambda: type(sample).deserialize(octets),
    )
    code, theirs = omniorb_type(described), omniorb_value(described, value)
    for order, little in ORDERS:
        body = omniORB.cdrMarshal(code, theirs, little)
        yield (
            f"omniORBpy, {order}",
            partial(omniORB.cdrMarshal, code, theirs, little),
            partial(omniORB.cdrUnmarshal, code, body, little),
        )


def copies(items: Any) -> Iterator[Row]:
    """Yield the bounds: a copy of the octets, and numpy."""
    octets, dtype = items.tobytes(), items.dtype
    yield (
        "a copy of the octets",
        lambda: bytearray(octets),
        lambda: bytearray(octets),
    )
    yield (
        "numpy.tobytes, frombuffer",
        items.tobytes,
        lambda: numpy.frombuffer(octets, dtype).copy(),
    )


def scans(types: Any, count: int) -> list[Row]:
    numbers = [i / 7 for i in range(count)]
    items = numpy.array(numbers)
    rows = [*copies(items), *ours("numpy", types.NumpyScan(1, items))]
    rows += ours("array", types.Scan(1, array("d", numbers)))
    rows += ours("XCDR2", types.OpenScan(1, array("d", numbers)), "xcdr2")
    rows += ours("list", types.ListScan(1, numbers))
    return [*rows, *peers(types.ListScan(1, numbers))]


def images(types: Any) -> list[Row]:
    pixels = bytes(range(256)) * 4096
    items = numpy.frombuffer(pixels, numpy.uint8)
    value = types.Image(1, pixels)
    return [*copies(items), *ours("bytes", value), *peers(value)]


def clouds(types: Any, count: int) -> list[Row]:
    points = [types.Point(i / 7, i / 3, -i / 7, 0.5) for i in range(count)]
    listed = types.Cloud(1, 0, points)
    value = types.Cloud.from_cdr(listed.to_cdr())
    assert value.points.dtype == idl.dtype(types.Point)
    return [*copies(value.points), *ours("numpy", value), *peers(listed)]


def report(table: Table, rounds: int, title: str, rows: list[Row]) -> None:
    """Fill the table with the rows of a value."""
    encode = least_times([row[1] for row in rows], rounds)
    decode = least_times([row[2] for row in rows], rounds)
    for row, *both in zip(rows, encode, decode, strict=True):
        least = encode[0], decode[0]
        pairs = zip(both, least, strict=True)
        figures = [n for taken, copy in pairs for n in (taken / 1000, taken / copy)]
        table.add(f"{title}, {row[0]}", *figures)


def main() -> None:
    """Print the table."""
    chosen = Arguments(__doc__, rounds=9).parse_args()
    with Results(__file__, chosen) as results, tempfile.TemporaryDirectory() as folder:
        types = generated(Path(folder))
        table = results.table(
            "copies",
            "value",
            ("encode [µs]", ".2f"),
            ("copies", ".2f"),
            ("decode [µs]", ".2f"),
            ("copies", ".2f"),
        )
        show = partial(report, table, chosen.rounds)
        for count in COUNTS[:1] if chosen.smallest else COUNTS:
            show(f"scan of {count:,} doubles", scans(types, count))
        if not chosen.smallest:
            show("image of 1 MB", images(types))
            for count in POINTS:
                show(f"cloud of {count:,} points", clouds(types, count))


if __name__ == "__main__":
    main()
