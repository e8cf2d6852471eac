"""Fuzzes the readers of IDL, CDL, EDS, profiles and CAN frames, and generated decoders.

    python tests/fuzz/idl.py KIND [--first N] [--count M] [--jobs J] [--failures DIR]
    python tests/fuzz/idl.py KIND --show N
    python tests/fuzz/idl.py --replay FILE

KIND is grammar, mutation, octets, cdl, eds, components (of EDS), slave or bus (frames), profiles,
hostile (definitions whose texts would be code without quoting, eight in a case), conversions (the
same for systems, modules of OpenRTM and convert), names (words of Python and of generated code),
texts (Japanese ones in three encodings) or growing (short definitions with large effects; a fixed
number of cases). A case's number determines
its input for one version of the fuzzer and, for mutations, of the definition files of this
repository. Each input that shows a defect is stored in DIR.
"""

from __future__ import annotations

import argparse
import re
import signal
import sys
import tempfile
from collections import defaultdict
from functools import partial
from pathlib import Path

from cdl import CdlTarget
from eds import ComponentsTarget, EdsTarget
from frames import BusTarget, NodeTarget
from fuzzing import SECONDS, Factory, Failure, Report, Watch, attempt, run
from growing import CASES, GrowthTarget
from hostile import ConversionsTarget, HostileTarget
from hostile_names import NamesTarget
from idl_grammar import is_valid, program
from idl_mutations import mutant
from idl_target import HELPERS, IdlTarget
from octets import OctetsTarget
from profiles import ProfileTarget
from texts import TextsTarget

KINDS: dict[str, Factory] = {
    "grammar": partial(IdlTarget, make=program, is_valid=is_valid),
    "mutation": partial(IdlTarget, make=mutant),
    "octets": OctetsTarget,
    "cdl": CdlTarget,
    "eds": EdsTarget,
    "components": ComponentsTarget,
    "slave": NodeTarget,
    "bus": BusTarget,
    "profiles": ProfileTarget,
    "hostile": HostileTarget,
    "growing": GrowthTarget,
    "conversions": ConversionsTarget,
    "names": NamesTarget,
    "texts": TextsTarget,
}


_WHERE = re.compile(r"[:\d]+(?=[ :,)]|$)|'[^']*'|span=.*")


def main() -> int:
    """Run the fuzzer; return 1 if there are failures."""
    parser = argparse.ArgumentParser(description=__doc__.split("\n")[0])
    parser.add_argument("kind", nargs="?", choices=KINDS, default="grammar")
    parser.add_argument("--first", type=int, default=0)
    parser.add_argument("--count", type=int, default=10_000)
    parser.add_argument("--jobs", type=int, default=1)
    parser.add_argument("--failures", type=Path, default=Path("build/fuzz"))
    parser.add_argument("--show", type=int)
    parser.add_argument("--replay", type=Path)
    arguments = parser.parse_args()
    signal.signal(signal.SIGTERM, signal.default_int_handler)
    factory = KINDS[arguments.kind]
    if arguments.show is not None:
        with tempfile.TemporaryDirectory() as folder:
            sys.stdout.buffer.write(factory(Path(folder)).make(arguments.show))
        return 0
    if arguments.replay:
        report = Report()
        with tempfile.TemporaryDirectory() as folder:
            data = arguments.replay.read_bytes()
            # Case 0 has all the checks that other cases have now and then.
            attempt(
                IdlTarget(Path(folder), mutant), 0, data, report, Watch(SECONDS / 2)
            )
    else:
        numbers = range(arguments.first, arguments.first + arguments.count)
        if arguments.kind == "growing":
            numbers = range(len(CASES))[numbers.start : numbers.stop]
        keeper = _Keeper(factory, arguments.failures)
        report = run(factory, numbers, jobs=arguments.jobs, progress=keeper.progress)
    print(report)
    _summarize(report.failures)
    return 1 if report.failures else 0


class _Keeper:
    """Prints the progress of a run, and stores the input and the traceback of each failure."""

    def __init__(self, factory: Factory, folder: Path) -> None:
        self._factory = factory
        self._folder = folder
        self._kept = 0

    def progress(self, report: Report) -> None:
        """Print the progress; called now and then."""
        rate = report.cases / report.seconds
        state = f"{report.cases} cases, {rate:.0f}/s, {len(report.failures)} failures"
        print(state, file=sys.stderr, flush=True)
        failures = report.failures[self._kept :]
        self._kept = len(report.failures)
        if not failures:
            return
        self._folder.mkdir(parents=True, exist_ok=True)
        with tempfile.TemporaryDirectory() as scratch:
            target = self._factory(Path(scratch))
            for failure in failures:
                path = self._folder / f"{failure.number}.idl"
                path.write_bytes(target.make(failure.number))
                path.with_suffix(".txt").write_text(failure.detail, encoding="utf-8")
        for name, data in HELPERS.items():
            (self._folder / name).write_bytes(data)
        print(f"inputs are in {self._folder}", file=sys.stderr, flush=True)


def _summarize(failures: list[Failure]) -> None:
    """Print one failure of each kind."""
    sorts: defaultdict[str, list[Failure]] = defaultdict(list)
    for failure in failures:
        sorts[_WHERE.sub("", failure.title)].append(failure)
    for title, same in sorts.items():
        print(f"\n{len(same)} x {title}\n{same[0].detail}")


if __name__ == "__main__":
    sys.exit(main())
