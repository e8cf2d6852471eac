"""`rtgen inspect --json` compared with `omniidl -bdump`: whole processes, interleaved, medians.

    python benchmarks/idl.py

A large synthetic file, and the small ones of OpenRTM. Cold: without cache, with bytecode. Cached:
the same run again, nothing changed. Then `inspect` and `generate` without cache, beside `omniidl
-bdump` and `-bpython`, of files of several shapes (`idl_shapes.py`): least processor times; with
`-Wbinline`, since rtgen, too, writes what included files declare. Last, a profile of a cold run of
the large file.
"""

from __future__ import annotations

import gc
import os
import shutil
import statistics
import sys
import tempfile
import time
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from importlib import import_module
from pathlib import Path
from typing import Any

from idl_shapes import SHAPES, synthetic
from tables import Arguments, Results, Table

ROOT = Path(__file__).resolve().parent.parent
BIG = "synthetic.idl"
SMALL = ("BasicDataType.idl", "ExtendedDataTypes.idl", "InterfaceDataTypes.idl")
LIMITS = {"cold": 3.0, "cached": 1.0, "small": 10.0}
"""Maximum ratio of a run to omniidl."""
COLD_LIMITS = {"inspect": 1.2, "generate": 2.0}
"""Maximum ratio to omniidl's processor time of a run of the large file without cache."""


@dataclass(slots=True)
class Figures:
    """Wall and processor times in seconds, peak memory in MB."""

    times: list[float] = field(default_factory=list)
    processor: list[float] = field(default_factory=list)
    peak: float = 0.0

    @property
    def median(self) -> float:
        """The median time."""
        return statistics.median(self.times)


Case = Callable[[], tuple[list[str], Mapping[str, str]]]


def measure(
    command: list[str], environment: Mapping[str, str]
) -> tuple[float, float, float]:
    """Return wall and processor time and memory of a process. Raises for a failure."""
    nowhere = [(os.POSIX_SPAWN_OPEN, fd, os.devnull, os.O_WRONLY, 0) for fd in (1, 2)]
    start = time.perf_counter()
    process = os.posix_spawn(command[0], command, environment, file_actions=nowhere)
    _, status, usage = os.wait4(process, 0)
    elapsed = time.perf_counter() - start
    if os.waitstatus_to_exitcode(status) != 0:
        raise SystemExit(f"failed: {' '.join(command)}")
    return elapsed, usage.ru_utime + usage.ru_stime, usage.ru_maxrss / 1024


def cases(file: str, omniidl: str, folder: Path) -> dict[str, Case]:
    """Return the measurements of a file: name to a command and its environment."""
    rtgen = [sys.executable, "-m", "rtgen", "inspect", "--json", file]
    kept = os.environ | {"RTGEN_CACHE_DIR": str(folder / "cache")}
    return {
        "omniidl": lambda: ([omniidl, "-bdump", file], os.environ),
        "cold": lambda: ([*rtgen, "--no-cache"], kept),
        "cached": lambda: (rtgen, kept),
    }


def figures(measured: Mapping[str, Case], rounds: int) -> dict[str, Figures]:
    """Return the figures of interleaved rounds, after one that warms up."""
    found = {name: Figures() for name in measured}
    for number in range(-1, rounds):
        for name, case in measured.items():
            elapsed, processor, peak = measure(*case())
            if number >= 0:
                found[name].times.append(elapsed)
                found[name].processor.append(processor)
                found[name].peak = max(found[name].peak, peak)
    return found


def tell(table: Table, file: str, lines: int, found: Mapping[str, Figures]) -> None:
    """Add the figures of a file."""
    base = found["omniidl"]
    for name, known in found.items():
        limit = LIMITS[name if file == BIG else "small"] if name != "omniidl" else None
        ratio = known.median / base.median
        processor = statistics.median(known.processor)
        processors = processor / statistics.median(base.processor)
        title = f"{file}, {lines:,} lines, {name}"
        times = known.median, ratio, processor, processors
        table.add(title, *times, known.peak, limit)


def shapes(table: Table, omniidl: str, rounds: int, *, smallest: bool) -> None:
    """Add the least processor times of `inspect` and `generate` for each shape."""
    rtgen = [sys.executable, "-m", "rtgen"]
    for name, made in [*SHAPES.items()][-1:] if smallest else SHAPES.items():
        texts = made()
        folder = Path(name.replace(" ", "_"))
        folder.mkdir()
        for file, text in texts.items():
            (folder / file).write_text(text, encoding="utf-8")
        file = str(folder / next(iter(texts)))
        output = str(folder / "output")
        (folder / "python").mkdir()
        found = figures(
            {
                "inspect": lambda f=file: (
                    [*rtgen, "inspect", "--json", "--no-cache", f],
                    os.environ,
                ),
                "-bdump": lambda f=file: (
                    [omniidl, "-bdump", "-Wbinline", f],
                    os.environ,
                ),
                "generate": lambda f=file, o=output: (
                    [*rtgen, "generate", "--no-cache", "-o", o, f],
                    os.environ,
                ),
                "-bpython": lambda f=file, o=folder: (
                    [omniidl, "-bpython", "-Wbinline", f"-C{o / 'python'}", f],
                    os.environ,
                ),
            },
            rounds,
        )
        least = {key: min(each.processor) for key, each in found.items()}
        row: list[float] = [sum(text.count("\n") for text in texts.values())]
        for ours, theirs in (("inspect", "-bdump"), ("generate", "-bpython")):
            row += [least[ours], least[theirs], least[ours] / least[theirs]]
        table.add(name, *row)


def stages(file: Path) -> dict[str, float]:
    """Return the processor time of each stage of a cold run, in this process."""
    spent: dict[str, float] = {}
    within = [0.0]

    def timed(name: str, function: Callable[..., Any]) -> Callable[..., Any]:
        """Return a function that records its time, less that of nested stages."""

        def wrapped(*args: Any, **kwargs: Any) -> Any:
            within.append(0.0)
            start = time.process_time()
            try:
                return function(*args, **kwargs)
            finally:
                elapsed = time.process_time() - start
                spent[name] = spent.get(name, 0.0) + elapsed - within.pop()
                within[-1] += elapsed

        return wrapped

    modules = timed("imports", lambda names: [import_module(name) for name in names])(
        [
            "rtgen.cli.inspect",
            "rtgen.compiler.inspection.models",
            "rtgen.compiler.frontends.idl.pipeline",
        ]
    )
    from rtgen.compiler.frontends.idl import pipeline, translation
    from rtgen.compiler.frontends.idl.lowering import lower
    from rtgen.compiler.frontends.idl.meaning import checks
    from rtgen.compiler.frontends.idl.names import resolver as names
    from rtgen.compiler.frontends.idl.syntax import parser
    from rtgen.compiler.frontends.idl.text import preprocessor

    for name, owner, attribute in (
        ("grammar", parser, "_grammar"),
        ("read", pipeline.Library, "open"),
        ("preprocess", preprocessor.Preprocessor, "translation_unit"),
        ("lex, parse, build tree", translation, "parse"),
        ("names", names.Resolver, "run"),
        ("types, lowering", lower.Lowering, "declaration"),
        ("checks", checks.Checker, "check"),
    ):
        setattr(owner, attribute, timed(name, getattr(owner, attribute)))
    gc.disable()
    result = timed("rest of the front end", pipeline.load)([file], root=file.parent)
    timed("JSON", modules[1].json_text)(result.model, result.diagnostics)
    gc.enable()
    start = time.process_time()
    scanner = parser._grammar().scanner
    for match in scanner.finditer(next(iter(result.sources.values()))):
        match[match.lastgroup]
    spent["(lex alone)"] = time.process_time() - start
    return spent


def main() -> None:
    """Print times, ratios and the profile."""
    chosen = Arguments(__doc__, rounds=5).parse_args()
    # Without bytecode most of a start would be Python's compiler.
    os.environ.pop("PYTHONDONTWRITEBYTECODE", None)
    omniidl = shutil.which(
        "omniidl", path=f"{Path(sys.executable).parent}:{os.environ['PATH']}"
    )
    if omniidl is None:
        raise SystemExit("omniidl: not found (pip install jeteve-omniorb)")
    with (
        Results(__file__, chosen) as results,
        tempfile.TemporaryDirectory() as temporary,
    ):
        folder = Path(temporary)
        os.chdir(folder)
        Path(BIG).write_text(synthetic(), encoding="utf-8")
        for name in SMALL:
            shutil.copy(ROOT / "specs" / "idl" / name, folder)
        table = results.table(
            "files",
            "file",
            ("elapsed [s]", ".3f"),
            ("times omniidl", ".2f"),
            ("processor time [s]", ".3f"),
            ("times omniidl", ".2f"),
            ("memory [MB]", ".0f"),
            ("limit", "g"),
        )
        for file in SMALL[:1] if chosen.smallest else (*SMALL, BIG):
            lines = Path(file).read_text(encoding="utf-8").count("\n")
            measured = figures(cases(file, omniidl, folder), chosen.rounds)
            tell(table, file, lines, measured)
        table = results.table(
            "shapes",
            "file",
            ("lines", ",d"),
            *(("inspect [s]", ".3f"), ("-bdump [s]", ".3f"), ("ratio", ".2f")),
            *(("generate [s]", ".3f"), ("-bpython [s]", ".3f"), ("ratio", ".2f")),
        )
        shapes(table, omniidl, chosen.rounds, smallest=chosen.smallest)
        start = {"": lambda: ([sys.executable, "-c", ""], os.environ)}
        empty = figures(start, chosen.rounds)[""]
        spent = {"start of Python": statistics.median(empty.processor)} | stages(
            Path(BIG)
        )
    lexing = spent.pop("(lex alone)")
    whole = sum(spent.values())
    print(f"\n{BIG}, cold, by stage, processor time")
    for name, seconds in spent.items():
        print(f"  {name:<24}{seconds * 1e3:>7.0f} ms{seconds / whole:>7.0%}")
    print(f"  of which lexing         {lexing * 1e3:>7.0f} ms{lexing / whole:>7.0%}")


if __name__ == "__main__":
    main()
