"""Start-up time: imports of generated modules, and starts of the command line.

    python benchmarks/startup.py

Processor time of whole processes, bytecode present unless stated; interleaved, medians, least
values, peak memory. Compared with: an empty interpreter of the same environment, `git status` of
the same tree, a module of plain classes with the same members, and `omniidl -bdump` of the
reference IDL files. The package of the stock types, which also contains other definitions, is
imported before them.
"""

from __future__ import annotations

import os
import shutil
import statistics
import subprocess
import sys
import tempfile
from collections.abc import Mapping
from dataclasses import dataclass, field
from enum import EnumMeta
from importlib import import_module
from pathlib import Path
from tempfile import TemporaryFile
from typing import Any

import msgspec
from tables import Arguments, Results

ROOT = Path(__file__).resolve().parent.parent
PACKAGE = "refrobots"
STOCK = [
    f"{PACKAGE}._idl.{name}"
    for name in ("basic_data_type", "extended_data_types", "interface_data_types")
]
SYSTEM = "specs/navigation/rh3_goal.xml"
IMPORT = """
import sys, time
import rtgen.runtime, rtgen.runtime.cdr, rtgen.runtime.idl
from importlib import import_module
for name in sys.argv[1:]:
    if "." in name:
        import_module(name.rpartition(".")[0])
begun = time.process_time()
for name in sys.argv[1:]:
    import_module(name)
print(time.process_time() - begun)
"""
LIMITS = {
    "import of the stock types": ("plain classes", 3.0),
    "rtgen --version": ("empty interpreter", 2.5),
}
"""Maximum ratios to the program compared with."""
COLD = "rtgen generate, cold"
UNCOMPILED = f"{COLD}, without bytecode"
CHECK = "rtgen check, nothing changed"
CHECK_UNCOMPILED = f"{CHECK}, without bytecode"
EXPLAIN = "rtgen explain"
SECONDS = {
    CHECK: 0.06,
    CHECK_UNCOMPILED: 0.2,
    EXPLAIN: 0.06,
    "rtgen run, to the first tick": 0.35,
    COLD: 1.0,
}


@dataclass(slots=True)
class Measured:
    """A command; `prints`: it prints the seconds itself, else those of its process count."""

    command: list[str]
    environment: Mapping[str, str] = field(default_factory=dict)
    prints: bool = False
    seconds: list[float] = field(default_factory=list)
    peak: float = 0.0
    """Peak memory of a run in MB."""

    def run(self, environment: Mapping[str, str]) -> float:
        """Return the processor time in seconds of one run."""
        with TemporaryFile("w+", encoding="utf-8") as output:
            process = subprocess.Popen(
                self.command,
                env={**os.environ, **self.environment, **environment},
                stdout=output,
                stderr=subprocess.DEVNULL,
            )
            _, status, usage = os.wait4(process.pid, 0)
            process.returncode = os.waitstatus_to_exitcode(status)
            if process.returncode:
                raise SystemExit(f"failed: {' '.join(self.command)}")
            self.peak = max(self.peak, usage.ru_maxrss / 1024)
            output.seek(0)
            return (
                float(output.read()) if self.prints else usage.ru_utime + usage.ru_stime
            )


def plain_classes(names: list[str]) -> str:
    """Return a module of classes without bases, with the members of generated modules."""
    lines: list[str] = []
    for name in names:
        module = import_module(name)
        for kind in vars(module).values():
            if isinstance(kind, type) and kind.__module__ == name:
                lines += _plain(kind)
    return "\n".join(lines)


def _plain(kind: type) -> list[str]:
    if isinstance(kind, EnumMeta):
        values = [f"    {key} = {value:d}" for key, value in kind.__members__.items()]
        return [f"class {kind.__name__}:", *values]
    members = getattr(kind, "__struct_fields__", ())
    if not members:
        return [f"class {kind.__name__}:", "    pass"]
    values = [f"{f.name}={_default(f)}" for f in msgspec.structs.fields(kind)]
    return [
        f"class {kind.__name__}:",
        f"    __slots__ = {tuple(members)!r}",
        f"    def __init__(self, {', '.join(values)}):",
        *(f"        self.{member} = {member}" for member in members),
    ]


def _default(member: Any) -> str:
    value = member.default
    return repr(value) if type(value) in (int, float, str, bytes) else "None"


def commands(folder: Path) -> dict[str, Measured]:
    """Return the measured commands by name."""
    plain = folder / "plain"
    plain.mkdir()
    (plain / "plain_classes.py").write_text(plain_classes(STOCK), encoding="utf-8")
    rtgen = [sys.executable, "-m", "rtgen"]
    warm = {"RTGEN_CACHE_DIR": str(folder / "cache")}
    uncompiled = {
        "PYTHONDONTWRITEBYTECODE": "1",
        "PYTHONPYCACHEPREFIX": str(folder / "none"),
    }
    paths = {"PYTHONPATH": os.pathsep.join(("generated", str(plain)))}
    found = {
        "empty interpreter": Measured([sys.executable, "-c", ""]),
        "rtgen --version": Measured([*rtgen, "--version"]),
        "rtgen --help": Measured([*rtgen, "--help"]),
        "git status": Measured(["git", "status"]),
        CHECK: Measured([*rtgen, "check"], warm),
        CHECK_UNCOMPILED: Measured([*rtgen, "check"], warm | uncompiled),
        "rtgen lint, nothing changed": Measured([*rtgen, "lint"], warm),
        "rtgen lint, no cache": Measured([*rtgen, "lint", "--no-cache"]),
        EXPLAIN: Measured([*rtgen, "explain", "IDL0200"]),
        "rtgen run, to the first tick": Measured(
            [*rtgen, "run", SYSTEM, "--until", "0.001"], warm
        ),
        "rtgen generate, no cache": Measured([*rtgen, "generate", "--no-cache"]),
        COLD: Measured([*rtgen, "generate", "-o", str(folder / "o")]),
        UNCOMPILED: Measured([*rtgen, "generate", "-o", str(folder / "o")]),
        "plain classes": Measured(
            [sys.executable, "-c", IMPORT, "plain_classes"], paths, prints=True
        ),
        "import of the stock types": Measured(
            [sys.executable, "-c", IMPORT, *STOCK], paths, prints=True
        ),
        "import of their package": Measured(
            [sys.executable, "-c", IMPORT, PACKAGE], paths, prints=True
        ),
    }
    omniidl = shutil.which(
        "omniidl", path=f"{Path(sys.executable).parent}:{os.environ['PATH']}"
    )
    if omniidl is None:
        print("omniidl: not found, so no peer (pip install jeteve-omniorb)")
    else:
        files = [str(f) for f in sorted(Path("specs/idl").glob("*.idl"))]
        found["omniidl -bdump, each file of the reference tree"] = Measured(
            [omniidl, "-bdump", "-I", "specs/idl", *files]
        )
    return found


def cold(folder: Path) -> dict[str, str]:
    """Return an environment with an empty cache, in which nothing has been generated."""
    for name in ("o", "cold", "bytecode"):
        shutil.rmtree(folder / name, ignore_errors=True)
    return {"RTGEN_CACHE_DIR": str(folder / "cold")}


def main() -> None:
    """Print medians, least values, memory and ratios."""
    chosen = Arguments(__doc__, rounds=9).parse_args()
    # Without bytecode most of a start would be Python's compiler.
    os.environ.pop("PYTHONDONTWRITEBYTECODE", None)
    os.chdir(ROOT)
    sys.path.insert(0, "generated")
    with (
        Results(__file__, chosen) as results,
        tempfile.TemporaryDirectory() as temporary,
    ):
        folder = Path(temporary)
        measured = commands(folder)
        # The first creates cache and bytecode.
        for number in range(0 if chosen.smallest else -1, chosen.rounds):
            for name, each in measured.items():
                environment = cold(folder) if name.startswith(COLD) else {}
                if name == UNCOMPILED:
                    environment["PYTHONPYCACHEPREFIX"] = str(folder / "bytecode")
                seconds = each.run(environment)
                if number < 0:
                    each.peak = 0.0
                else:
                    each.seconds.append(seconds)
        least = {name: min(each.seconds) for name, each in measured.items()}
        table = results.table(
            "processes",
            "processor time",
            ("median [ms]", ".1f"),
            ("least [ms]", ".1f"),
            ("memory [MB]", ".0f"),
            "limit",
        )
        for name, each in measured.items():
            median = statistics.median(each.seconds)
            verdict = _verdict(name, least)
            table.add(name, 1e3 * median, 1e3 * least[name], each.peak, verdict)


def _verdict(name: str, least: Mapping[str, float]) -> str:
    if name in SECONDS:
        return f"at most {1e3 * SECONDS[name]:.0f} ms"
    if name in LIMITS:
        yardstick, most = LIMITS[name]
        ratio = least[name] / least[yardstick]
        return f"{ratio:.2f} times {yardstick}, at most {most:g}"
    return ""


if __name__ == "__main__":
    main()
