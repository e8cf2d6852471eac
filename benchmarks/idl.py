"""`rtgen inspect --json` compared with `omniidl -bdump`: whole processes, interleaved, medians.

A large synthetic file, and the small ones of OpenRTM. Cold: without cache, with bytecode. Cached:
the same run again, nothing changed. Then `inspect` and `generate` without cache, beside `omniidl
-bdump` and `-bpython`, of files of several shapes (`idl_shapes.py`): least processor times. Last, a
profile of a cold run of the large file.
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

ROOT = Path(__file__).resolve().parent.parent
ROUNDS = 5
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


def figures(measured: Mapping[str, Case]) -> dict[str, Figures]:
    """Return the figures of interleaved rounds, after one that warms up."""
    found = {name: Figures() for name in measured}
    for number in range(-1, ROUNDS):
        for name, case in measured.items():
            elapsed, processor, peak = measure(*case())
            if number >= 0:
                found[name].times.append(elapsed)
                found[name].processor.append(processor)
                found[name].peak = max(found[name].peak, peak)
    return found


def tell(file: str, lines: int, found: Mapping[str, Figures]) -> None:
    """Print the figures of a file."""
    base = found["omniidl"]
    for name, known in found.items():
        limit = LIMITS[name if file == BIG else "small"] if name != "omniidl" else None
        ratio = known.median / base.median
        processor = statistics.median(known.processor)
        processors = processor / statistics.median(base.processor)
        told = (
            "" if limit is None else f"  (limit {limit:g}{' MISSED' * (ratio > limit)})"
        )
        print(
            f"{file:<24}{lines:>6}  {name:<8}{known.median:>8.3f} s{ratio:>6.2f} x"
            f"{processor:>8.3f} s{processors:>6.2f} x{known.peak:>6.0f} MB{told}"
        )


def shapes(omniidl: str) -> None:
    """Print the least processor times of `inspect` and `generate` for each shape."""
    rtgen = [sys.executable, "-m", "rtgen"]
    print(f"\nno cache, least processor times\n{'':<16}{'lines':>7}", end="")
    print("   inspect   -bdump            generate -bpython")
    for name, made in SHAPES.items():
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
                "-bdump": lambda f=file: ([omniidl, "-bdump", f], os.environ),
                "generate": lambda f=file, o=output: (
                    [*rtgen, "generate", "--no-cache", "-o", o, f],
                    os.environ,
                ),
                "-bpython": lambda f=file, o=folder: (
                    [omniidl, "-bpython", f"-C{o / 'python'}", f],
                    os.environ,
                ),
            }
        )
        least = {key: min(each.processor) for key, each in found.items()}
        print(f"{name:<16}{sum(t.count(chr(10)) for t in texts.values()):>7}", end="")
        for ours, theirs in (("inspect", "-bdump"), ("generate", "-bpython")):
            ratio = least[ours] / least[theirs]
            missed = file.endswith(BIG) and ratio > COLD_LIMITS[ours]
            print(
                f"{least[ours]:>8.3f} s{least[theirs]:>7.3f} s{ratio:>6.2f} x"
                f"{' MISSED' * missed}",
                end="",
            )
        print()


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
        ("checks", checks, "run"),
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
    # Without bytecode most of a start would be Python's compiler.
    os.environ.pop("PYTHONDONTWRITEBYTECODE", None)
    omniidl = shutil.which(
        "omniidl", path=f"{Path(sys.executable).parent}:{os.environ['PATH']}"
    )
    if omniidl is None:
        raise SystemExit("omniidl: not found (pip install jeteve-omniorb)")
    with tempfile.TemporaryDirectory() as temporary:
        folder = Path(temporary)
        os.chdir(folder)
        Path(BIG).write_text(synthetic(), encoding="utf-8")
        for name in SMALL:
            shutil.copy(ROOT / "specs" / "idl" / name, folder)
        print(
            f"Python {sys.version.split()[0]}, median of {ROUNDS}; wall, then processor time"
        )
        for file in (*SMALL, BIG):
            lines = Path(file).read_text(encoding="utf-8").count("\n")
            tell(file, lines, figures(cases(file, omniidl, folder)))
        shapes(omniidl)
        empty = figures({"": lambda: ([sys.executable, "-c", ""], os.environ)})[""]
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
