"""Large payloads: a scan of doubles as CDR, beside the same octets by `array`, numpy and a copy.

    python benchmarks/payload.py

Least processor time of a call in microseconds, in both byte orders, for scans of 100 to 1,000,000
doubles. `list` and `array.array` are what the member holds when it is encoded; what is decoded is
a list. `through array` makes that list by `array.array`; `to array` stops before that.
"""

from __future__ import annotations

import importlib
import sys
import tempfile
import time
from array import array
from collections.abc import Callable
from pathlib import Path
from typing import Any

COUNTS = (100, 1_000, 10_000, 100_000, 1_000_000)
ROUNDS = 15
VALUES_PER_ROUND = 100_000
IDL = "struct Scan { long stamp; sequence<double> ranges; };"

Task = Callable[[], object]


def scan_class(folder: Path) -> Any:
    """The generated class of the scan."""
    from rtgen.backends import Options
    from rtgen.backends.types import BACKEND
    from rtgen.frontends.idl import load

    file = folder / "scan.idl"
    file.write_text(IDL, encoding="utf-8")
    model = load([file], root=folder).model
    emission = BACKEND.emit(model, Options("bench_payload", "skeletons", "0"))
    for artifact in emission.artifacts:
        path = folder / artifact.path
        path.parent.mkdir(parents=True, exist_ok=True)
        path.write_text(artifact.text, encoding="utf-8")
    sys.path.insert(0, str(folder))
    return importlib.import_module("bench_payload._idl.scan").Scan


def tasks(scan: Any, count: int) -> dict[str, Task]:
    """What is measured for a number of doubles."""
    numbers = [i / 7 for i in range(count)]
    items = array("d", numbers)
    octets = items.tobytes()
    listed, buffered = scan(1, numbers), scan(1, items)
    little, big = listed.to_cdr(), listed.to_cdr(False)
    assert buffered.to_cdr() == little

    def to_array() -> array[float]:
        made = array("d")
        made.frombytes(octets)
        return made

    found: dict[str, Task] = {
        "encode list": listed.to_cdr,
        "encode list, big-endian": lambda: listed.to_cdr(False),
        "encode array.array": buffered.to_cdr,
        "decode": lambda: scan.from_cdr(little),
        "decode, big-endian": lambda: scan.from_cdr(big, False),
        "array.tobytes": items.tobytes,
        "to array": to_array,
        "through array": lambda: to_array().tolist(),
        "copy of the octets": lambda: bytearray(octets),
    }
    try:
        import numpy
    except ImportError:
        return found
    values = numpy.array(numbers)
    found["numpy.tobytes"] = values.tobytes
    found["numpy.frombuffer, copied"] = lambda: numpy.frombuffer(octets).copy()
    return found


def measured(all_tasks: dict[str, Task], calls: int) -> dict[str, float]:
    """Microseconds of each task; rounds of all tasks are interleaved."""
    least = dict.fromkeys(all_tasks, float("inf"))
    for _ in range(ROUNDS):
        for name, task in all_tasks.items():
            begun = time.process_time()
            for _ in range(calls):
                task()
            least[name] = min(least[name], (time.process_time() - begun) / calls)
    return {name: seconds * 1e6 for name, seconds in least.items()}


def main() -> None:
    with tempfile.TemporaryDirectory() as folder:
        scan = scan_class(Path(folder))
        rows: dict[str, list[float]] = {}
        for count in COUNTS:
            calls = max(1, VALUES_PER_ROUND // count)
            for name, least in measured(tasks(scan, count), calls).items():
                rows.setdefault(name, []).append(least)
    print(f"{'':26}" + "".join(f"{count:>13,}" for count in COUNTS))
    for name, figures in rows.items():
        print(f"{name:26}" + "".join(f"{figure:13,.2f}" for figure in figures))


if __name__ == "__main__":
    main()
