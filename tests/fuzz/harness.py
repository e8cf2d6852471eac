"""Explores doors: guided by coverage if atheris is installed, else by random inputs.

    python tests/fuzz/harness.py DOOR... [--seconds S] [--runs N] [--keep]
    python tests/fuzz/harness.py DOOR... --total N [--first M] [--seconds S]
    python tests/fuzz/harness.py DOOR... --types N [--first M]

An input that takes over 10 s or 500 MB, or that raises an undocumented exception, is written to
`build/fuzz/DOOR/` with its traceback; the exit code is then 1. A line for each door summarizes the
run. `--keep` adds to `corpus/DOOR` the smallest inputs that reach lines which no other input
reaches.

`--total` gives each door N numbered random inputs, without instrumentation. The door with the
fewest inputs so far is next. `build/fuzz/inputs.json` counts them, so that a stopped run continues
there, or at number M if it has no count of the door; the number of an input alone determines its
octets.

`--types` generates the Python of numbered inputs of each door of definitions, from number M on,
until there are N packages, which must import, round-trip and type-check (`accepted.py`).
"""

from __future__ import annotations

import argparse
import hashlib
import json
import logging
import multiprocessing
import os
import re
import shutil
import subprocess
import sys
import tempfile
import time
import traceback
from collections.abc import Iterator, Sequence
from concurrent.futures import ProcessPoolExecutor
from functools import partial
from importlib.util import find_spec
from pathlib import Path
from random import Random
from types import FrameType, TracebackType

import fuzzing
from doors import CORPUS, MODULES, Door, corpus, door
from doors.mixing import ROOT, mixing

FOUND = ROOT / "build/fuzz"
SECONDS_OF_INPUT = 10
MEGABYTES = 500
_BASE_MEGABYTES = 400
"""Memory of the interpreter, rtgen and its instrumentation [MB]."""
_MAX_OCTETS = 4096
_MAX_KEPT = 60
_SECONDS_OF_KEEPING = 60
_DEFECT_PREFIX = "defect-"
"""Prefix of the names of inputs that once showed a defect; they are kept."""
_DRAWN_SHARE = 0.2
"""The share of inputs that are drawn by the grammar instead of mutated."""
_PACKAGES = 500
"""Number of packages that mypy checks at once."""
_MAX_DRAWN = 200
"""Maximum number of inputs drawn for a package."""
_FIRST_CHUNK = 1000
_SECONDS_OF_CHUNK = 60
_EXECUTED = re.compile(r"stat::number_of_executed_units:\s*(\d+)")
_TIME = re.compile(r"stat::slowest_unit_time_sec:\s*(\d+)")
_PEAK = re.compile(r"stat::peak_rss_mb:\s*(\d+)")


class DoorTarget:
    """A door for `fuzzing.run`: inputs by its grammar, and mutations of kept ones and of seeds."""

    def __init__(self, name: str, folder: Path) -> None:
        logging.disable()
        self._door = door(name, folder)
        known = [path.read_bytes() for path in corpus(name)]
        known += (seed for seed in self._door.seeds if len(seed) <= _MAX_OCTETS)
        self._known = sorted(known, key=len) or [b""]
        self._mix = mixing(self._known)

    def make(self, number: int) -> bytes:
        """Return the input of a case."""
        chance = Random(number)
        if chance.random() < _DRAWN_SHARE:
            return self._door.make(chance)
        if chance.random() < 0.5:
            return self._mix(chance)[:_MAX_OCTETS]
        # Small inputs are chosen most often, since they are the fastest.
        data = bytearray(self._known[int(len(self._known) * chance.random() ** 2)])
        for _ in range(chance.randrange(1, 6)):
            at = chance.randrange(len(data) + 1)
            data[at : at + chance.randrange(3)] = chance.randbytes(chance.randrange(4))
        return bytes(data)

    def check(self, number: int, data: bytes) -> list[str]:
        """Give the input to the door."""
        return ["accepted" if self._door.enter(data) else "refused"]


def _place(error: BaseException) -> str:
    """Return the kind of an exception and the last line of rtgen in its traceback."""
    where = ""
    trace: TracebackType | None = error.__traceback__
    while trace is not None:
        file = trace.tb_frame.f_code.co_filename
        if "/rtgen/" in file:
            where = f"{file.rpartition('/rtgen/')[2]}:{trace.tb_lineno}"
        trace = trace.tb_next
    return f"{type(error).__name__} {where}"


def _report(folder: Path, error: BaseException, data: bytes) -> None:
    """Store the first input for each place where an exception was raised."""
    name = hashlib.sha256(_place(error).encode()).hexdigest()[:12]
    file = folder / f"raised-{name}"
    if not file.exists():
        file.write_bytes(data)
        text = "".join(traceback.format_exception(error))
        file.with_suffix(".txt").write_text(text)


def _explore(name: str, arguments: list[str]) -> None:
    """Explore a door by libFuzzer, which ends the process."""
    import atheris

    folder = FOUND / name
    logging.disable()
    sys.setrecursionlimit(1000)
    with tempfile.TemporaryDirectory() as scratch:
        with atheris.instrument_imports(
            include=["rtgen"], enable_loader_override=False
        ):
            opened: Door = door(name, Path(scratch))

        def one(data: bytes) -> None:
            try:
                opened.enter(data)
            except Exception as error:  # the defect that is looked for
                _report(folder, error, data)

        def mutated(data: bytes, size: int, number: int) -> bytes:
            chance = Random(number)
            if chance.random() < _DRAWN_SHARE:
                return opened.make(chance)[:size]
            found: bytes = atheris.Mutate(data, size)
            return found

        atheris.Setup([name, *arguments], one, custom_mutator=mutated)
        atheris.Fuzz()


def _child(name: str, arguments: list[str]) -> str:
    """Return libFuzzer's output; its findings are files of `build/fuzz/DOOR`."""
    command = [sys.executable, __file__, "--inside", name, "--", *arguments]
    done = subprocess.run(
        command, capture_output=True, text=True, errors="replace", check=False
    )
    return done.stdout + done.stderr


def explored(name: str, seconds: float, runs: int, seed: int) -> tuple[str, bool]:
    """Explore a door for a time or a number of inputs; return a summary and whether it passed."""
    folder = FOUND / name
    shutil.rmtree(folder, ignore_errors=True)
    found = folder / "reached"
    found.mkdir(parents=True)
    with tempfile.TemporaryDirectory() as scratch:
        for data in door(name, Path(scratch)).seeds:
            (found / hashlib.sha256(data).hexdigest()[:16]).write_bytes(data)
    if find_spec("atheris") is None:
        line = _by_chance(name, seconds, runs, seed)
    else:
        line = _guided(name, folder, seconds, runs, seed)
    bad = sorted(p for p in folder.iterdir() if p.is_file() and p.suffix != ".txt")
    for path in bad:
        line += f"\n  {path.relative_to(ROOT)}"
        if (text := path.with_suffix(".txt")).exists():
            line += f": {text.read_text().rstrip().rpartition(chr(10))[2][:200]}"
    return line, not bad


def _guided(name: str, folder: Path, seconds: float, runs: int, seed: int) -> str:
    count, slowest, peak = 0, 0, 0
    end = time.monotonic() + seconds
    while (left := end - time.monotonic()) > 1 and (not runs or count < runs):
        limits = [
            f"-max_total_time={round(left)}",
            f"-runs={runs - count if runs else -1}",
        ]
        text = _child(
            name,
            [
                *limits,
                f"-timeout={SECONDS_OF_INPUT}",
                f"-rss_limit_mb={MEGABYTES + _BASE_MEGABYTES}",
                f"-max_len={_MAX_OCTETS}",
                f"-seed={seed % 2**31}",
                f"-artifact_prefix={folder}/",
                "-print_final_stats=1",
                "-verbosity=0",
                str(folder / "reached"),
                *([str(CORPUS / name)] if corpus(name) else []),
            ],
        )
        executed = _EXECUTED.search(text)
        if executed is None:
            (folder / "stopped").write_text(text[-10_000:])
            break
        count += int(executed[1])
        slowest = max(slowest, *(int(each) for each in _TIME.findall(text)))
        peak = max(peak, *(int(each) for each in _PEAK.findall(text)))
        if len(list(folder.glob("timeout-*"))) + len(list(folder.glob("oom-*"))) > 5:
            break
    return f"{name:<14} {count:>9} inputs, slowest {slowest} s, peak {peak} MB"


def _by_chance(name: str, seconds: float, runs: int, seed: int) -> str:
    total, first = fuzzing.Report(), seed * 10_000_000
    end = time.monotonic() + seconds
    while time.monotonic() < end and (not runs or total.cases < runs):
        start = first + total.cases
        found = fuzzing.run(partial(DoorTarget, name), range(start, start + 10_000))
        total.add(found)
        _keep_failures(name, found)
    return _line(name, total)


def bulk(
    names: Sequence[str], total: int, seconds: float, first: int = 0
) -> Iterator[tuple[str, bool]]:
    """Give each door the inputs up to `total`, by default from number `first` on.

    Yields a summary after each tenth, and whether it passed.
    """
    file = FOUND / "inputs.json"
    done: dict[str, int] = json.loads(file.read_text()) if file.exists() else {}
    reports = {name: fuzzing.Report() for name in names}
    sizes = dict.fromkeys(names, _FIRST_CHUNK)
    end = time.monotonic() + seconds
    while time.monotonic() < end:
        name = min(names, key=lambda name: done.get(name, first))
        start = done.get(name, first)
        if start >= total:
            break
        numbers = range(start, min(start + sizes[name], total))
        found = fuzzing.run(partial(DoorTarget, name), numbers, chunk=len(numbers))
        _keep_failures(name, found)
        if found.cases < len(numbers) and not found.failures:  # interrupted
            break
        done[name] = start + found.cases
        file.parent.mkdir(parents=True, exist_ok=True)
        file.write_text(json.dumps(done, indent=1, sort_keys=True) + "\n")
        reports[name].add(found)
        sizes[name] = _next_chunk(found)
        if found.failures or start * 10 // total < done[name] * 10 // total:
            yield f"{_line(name, reports[name])}, {done[name]} in all", not found.failures


def _next_chunk(found: fuzzing.Report) -> int:
    """Return the number of inputs that take about a minute."""
    rate = found.cases / max(found.processor, 0.1)
    return max(_FIRST_CHUNK, round(rate * _SECONDS_OF_CHUNK))


def _line(name: str, found: fuzzing.Report) -> str:
    slowest, peak = found.slowest[0], found.peak // 2**20
    rate = found.cases / found.processor if found.processor else 0.0
    return (
        f"{name:<14} {found.cases:>9} inputs, {rate:.0f} per second of a processor,"
        f" slowest {slowest:.1f} s, peak {peak} MB"
    )


def _keep_failures(name: str, found: fuzzing.Report) -> None:
    """Store the input and the traceback of each case that failed."""
    folder = FOUND / name
    with tempfile.TemporaryDirectory() as scratch:
        target = DoorTarget(name, Path(scratch)) if found.failures else None
        for failure in found.failures:
            assert target is not None
            folder.mkdir(parents=True, exist_ok=True)
            file = folder / f"case-{failure.number}"
            file.write_bytes(target.make(failure.number))
            file.with_suffix(".txt").write_text(failure.detail)


def typed(name: str, count: int, first: int = 0) -> Iterator[tuple[str, bool]]:
    """Check packages of inputs from number `first` on; yield a summary after each batch."""
    number, packages = first, 0
    while packages < count:
        # In a process of its own, since imported modules leave something in memory.
        context = multiprocessing.get_context("spawn")
        with ProcessPoolExecutor(1, mp_context=context) as worker:
            size = min(_PACKAGES, count - packages)
            end, made, failures = worker.submit(_batch, name, number, size).result()
        folder = FOUND / name
        for each, (data, detail) in failures.items():
            folder.mkdir(parents=True, exist_ok=True)
            (folder / f"types-{each}").write_bytes(data)
            (folder / f"types-{each}.txt").write_text(detail)
        number, packages = end, packages + made
        tried = number - first
        line = f"{name:<14} {packages:>9} packages of {tried} inputs"
        yield f"{line}, {len(failures)} failures", not failures
        if made < size:
            break


def _batch(
    name: str, first: int, count: int
) -> tuple[int, int, dict[int, tuple[bytes, str]]]:
    """Return the next number, the number of packages, and inputs with failures."""
    from accepted import Packages

    prefix = f"{name.replace('-', '_')}_"
    number, made = first, 0
    with tempfile.TemporaryDirectory() as scratch:
        target = DoorTarget(name, Path(scratch))
        packages = Packages(Path(scratch) / "packages")
        while made < count and number < first + _MAX_DRAWN * count:
            made += packages.add(f"{prefix}{number}", name, target.make(number))
            number += 1
        packages.check_types()
    found = {int(k.removeprefix(prefix)): v for k, v in packages.failures.items()}
    return number, made, {n: (target.make(n), found[n]) for n in sorted(found)}


def keep(name: str) -> int:
    """Store the smallest inputs that reach lines which smaller ones do not; return their number."""
    paths = [*(FOUND / name / "reached").iterdir(), *corpus(name)]
    inputs = {data for data in map(Path.read_bytes, paths) if len(data) <= _MAX_OCTETS}
    reached: set[tuple[str, int]] = set()
    kept: list[bytes] = []
    answers: set[bool] = set()
    logging.disable()
    with tempfile.TemporaryDirectory() as scratch:
        opened = door(name, Path(scratch))
        end = time.monotonic() + _SECONDS_OF_KEEPING
        for data in sorted(inputs, key=lambda data: (len(data), data)):
            try:
                lines, answer = _lines(opened, data)
            except Exception:  # an input that raises was reported when it was found
                continue
            if lines <= reached and answer in answers:
                continue
            reached |= lines
            answers.add(answer)
            kept.append(data)
            if len(kept) == _MAX_KEPT or time.monotonic() > end:
                break
    for path in corpus(name):
        if not path.name.startswith(_DEFECT_PREFIX):
            path.unlink()
    (CORPUS / name).mkdir(parents=True, exist_ok=True)
    for data in kept:
        (CORPUS / name / hashlib.sha256(data).hexdigest()[:16]).write_bytes(data)
    return len(kept)


def _lines(opened: Door, data: bytes) -> tuple[set[tuple[str, int]], bool]:
    """Return the lines of rtgen that an input reaches, and whether it is accepted."""
    reached: set[tuple[str, int]] = set()

    def trace(frame: FrameType, _event: str, _value: object) -> object:
        file = frame.f_code.co_filename
        if "/rtgen/" not in file:
            return None
        reached.add((file, frame.f_lineno))
        return trace

    sys.settrace(trace)
    try:
        return reached, opened.enter(data)
    finally:
        sys.settrace(None)


def main() -> int:
    """Explore the named doors, or all."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("doors", nargs="*", metavar="DOOR", help=", ".join(MODULES))
    parser.add_argument("--seconds", type=float, default=60.0, help="for each door")
    parser.add_argument("--runs", type=int, default=0, help="maximum number of inputs")
    parser.add_argument("--keep", action="store_true", help="renew the corpus")
    parser.add_argument("--total", type=int, help="number of random inputs per door")
    parser.add_argument(
        "--types", type=int, help="number of packages to check per door"
    )
    parser.add_argument(
        "--first", type=int, default=0, help="number of the first input"
    )
    seed = int(os.environ.get("RTGEN_SEED", time.time()))
    parser.add_argument(
        "--seed", type=int, default=seed, help="[RTGEN_SEED, or the time]"
    )
    given = parser.parse_args()
    unknown = sorted(set(given.doors).difference(MODULES))
    if unknown:
        parser.error(f"there is no door {', '.join(unknown)}: {', '.join(MODULES)}")
    good = True
    if given.types is not None:
        from accepted import DOORS

        unknown = sorted(set(given.doors).difference(DOORS))
        if unknown:
            parser.error(
                f"no Python is made of {', '.join(unknown)}: {', '.join(DOORS)}"
            )
        for name in given.doors or DOORS:
            for line, sound in typed(name, given.types, given.first):
                print(line, flush=True)
                good &= sound
        return 0 if good else 1
    if given.total is not None:
        names = given.doors or list(MODULES)
        for line, sound in bulk(
            names, given.total, given.seconds * len(names), given.first
        ):
            print(line, flush=True)
            good &= sound
        return 0 if good else 1
    for name in given.doors or MODULES:
        line, sound = explored(name, given.seconds, given.runs, given.seed)
        kept = f", {keep(name)} kept" if given.keep else ""
        print(line + kept, flush=True)
        good &= sound
    return 0 if good else 1


if __name__ == "__main__":
    if sys.argv[1:2] == ["--inside"]:
        _explore(sys.argv[2], sys.argv[4:])
    else:
        sys.exit(main())
