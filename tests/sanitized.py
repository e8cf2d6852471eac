"""Explores the codecs in C with the sanitizers of addresses and of undefined behaviour.

    python tests/sanitized.py [--seconds S] [--first N]

The module is built in `build/sanitized` by gcc. A case changes the octets of a type, in CDR, XCDR1
or XCDR2, decodes and encodes them, as in `tests/fuzz/idl.py octets`; then it decodes each beginning
of the last ones that had a value, and these with each octet changed. At the first finding the
program ends with the report of the sanitizer; `--first` is the case to go on with.
"""

from __future__ import annotations

import argparse
import os
import subprocess
import sys
import tempfile
import time
from array import array
from collections import Counter
from collections.abc import Callable, Iterator
from pathlib import Path
from random import Random

import speed

FILE = speed.ROOT / "build" / "sanitized" / speed.FILE.name
FLAGS = "-fsanitize=address,undefined -fno-sanitize-recover=all"
_CHUNK = 50
"""Cases between two looks at the clock."""
_CHANGES = 40
_LONGEST = 400
_OCTETS = (b"\x00", b"\x01", b"\x04", b"\x7f", b"\x80", b"\xff")


def environment() -> dict[str, str]:
    """Build the module; return the variables of a process that uses it.

    Raises CalledProcessError or OSError if gcc or its sanitizers are missing.
    """
    libraries = [_library(name) for name in ("libasan.so", "libubsan.so")]
    speed.build(FILE, CC="gcc", CFLAGS=f"-g -O1 {FLAGS}", LDFLAGS=FLAGS)
    return {
        **os.environ,
        "LD_PRELOAD": " ".join(libraries),
        # Python frees little at its end, and its own blocks would hide errors.
        "ASAN_OPTIONS": "detect_leaks=0:allocator_may_return_null=1",
        "UBSAN_OPTIONS": "print_stacktrace=1",
        "PYTHONMALLOC": "malloc",
        "PYTHONPATH": str(FILE.parent),
        "RTGEN_CODEC": "c",
    }


def _library(name: str) -> str:
    command = ["gcc", f"-print-file-name={name}"]
    path = subprocess.run(command, check=True, capture_output=True, text=True).stdout
    if not Path(path.strip()).is_absolute():
        raise FileNotFoundError(f"gcc has no {name}")
    return path.strip()


def explore(seconds: float, first: int) -> Counter[str]:
    """Decode and encode for a time; return the outcomes of the inputs."""
    sys.path.insert(0, str(Path(__file__).parent / "fuzz"))
    import octets
    import rtgen_speed

    assert Path(rtgen_speed.__file__) == FILE
    outcomes: Counter[str] = Counter()
    number, end = first, time.monotonic() + seconds
    with tempfile.TemporaryDirectory() as folder:
        encodings = octets.OctetsTarget(Path(folder)).encodings
    while time.monotonic() < end:
        print(f"cases {number} to {number + _CHUNK - 1}", end="\r", flush=True)
        for case in range(number, number + _CHUNK):
            chance = Random(case)
            encoding = chance.choice(encodings)
            grown = encoding.least
            for changed, outcome in octets.explore(encoding, chance, _CHANGES):
                outcomes[outcome] += 1
                if outcome.endswith("value"):
                    grown = changed
            for changed in _neighbours(grown[:_LONGEST]):
                outcomes[_decoded(encoding.read, changed)] += 1
        number += _CHUNK
    return outcomes


def _neighbours(octets: bytes) -> Iterator[bytes]:
    """Yield each beginning, and the octets with one changed."""
    for end in range(len(octets)):
        yield octets[:end]
    for place in range(len(octets)):
        for octet in _OCTETS:
            yield octets[:place] + octet + octets[place + 1 :]


def _decoded(read: Callable[[bytes], object], data: bytes) -> str:
    from rtgen.runtime.cdr import CdrError

    try:
        # A block of this very length: bytes have one more octet, arrays have room to grow.
        read(memoryview(array("B", data) * 1))  # type: ignore[arg-type]
    except CdrError:
        return "decoded: CdrError"
    return "decoded: value"


def main() -> int:
    """Run in a process with the sanitizers; return its exit code."""
    parser = argparse.ArgumentParser(description=__doc__.split("\n")[0])
    parser.add_argument("--seconds", type=float, default=60.0)
    parser.add_argument("--first", type=int, default=0)
    arguments = parser.parse_args()
    if "LD_PRELOAD" not in os.environ:
        command = [sys.executable, *sys.argv]
        return subprocess.run(command, env=environment(), check=False).returncode
    outcomes = explore(arguments.seconds, arguments.first)
    print()
    for outcome, times in sorted(outcomes.items()):
        print(f"{times:12,} {outcome}")
    print(f"{outcomes.total():12,} inputs without a finding")
    return 0


if __name__ == "__main__":
    sys.exit(main())
