"""Explores the codecs in C with the sanitizers of addresses and of undefined behaviour.

    python tests/sanitized.py [--seconds S] [--first N]

The module is built in `build/sanitized` by gcc. A case changes the octets of a type, in CDR, XCDR1
or XCDR2, decodes and encodes them: a few as in `tests/fuzz/idl.py octets`, and many by
`speed/src/explorer.c`, which calls no Python. At the first finding the program ends with the report
of the sanitizer, or with the octets; `--first` is the case to go on with.
"""

from __future__ import annotations

import argparse
import os
import subprocess
import sys
import tempfile
import time
from collections import Counter
from pathlib import Path
from random import Random
from typing import Any

import speed

from rtgen.runtime.marshalling.compiler import compiled
from rtgen.runtime.marshalling.layouts.formats import Format

FILE = speed.ROOT / "build" / "sanitized" / speed.FILE.name
FLAGS = "-fsanitize=address,undefined -fno-sanitize-recover=all"
_CHUNK = 5
"""Cases between two looks at the clock."""
_CHANGES = 40
_INPUTS = 20_000
"""Octets of a case that the explorer in C changes."""


def environment() -> dict[str, str]:
    """Build the module; return the variables of a process that uses it.

    Raises CalledProcessError or OSError if gcc or its sanitizers are missing.
    """
    libraries = [_library(name) for name in ("libasan.so", "libubsan.so")]
    speed.build(
        FILE, CC="gcc", CFLAGS=f"-g -O1 -DRTGEN_EXPLORER {FLAGS}", LDFLAGS=FLAGS
    )
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
            for _, outcome in octets.explore(encoding, chance, _CHANGES):
                outcomes[outcome] += 1
            outcomes.update(_explored(rtgen_speed, encoding, case))
        number += _CHUNK
    return outcomes


def _explored(module: Any, encoding: Any, case: int) -> dict[str, int]:
    """Return the outcomes of the explorer in C; none for a type without codecs in C."""
    from octets import VERSIONS

    format_ = Format(VERSIONS[encoding.name] or 0)
    functions = [
        compiled(kind, encoding.type._descriptor_, format_)
        for kind in ("from_cdr", "to_cdr", "_snapshot_")
    ]
    codecs = [getattr(each, "__self__", each) for each in functions]
    if not all(isinstance(codec, module.Codec) for codec in codecs):
        return {}
    counts = module.explore(
        *codecs, encoding.least, encoding.little_endian, case, _INPUTS
    )
    return dict(
        zip(("C: CdrError", "C: value", "C: read-only value"), counts, strict=True)
    )


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
