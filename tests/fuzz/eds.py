"""Fuzzing of device descriptions: any file gives findings in the file, or a device."""

from __future__ import annotations

import json
import sys
from collections.abc import Callable, Iterator
from contextlib import chdir
from functools import cache
from importlib import import_module, invalidate_caches
from pathlib import Path
from pkgutil import walk_packages
from random import Random

from fuzzing import ViolationError, log_uniform

from rtgen.compiler.compilation import compile_project
from rtgen.compiler.diagnostics import Diagnostic, has_errors
from rtgen.compiler.diagnostics.report import report
from rtgen.compiler.frontends.eds import load
from rtgen.compiler.frontends.eds.findings import MAX_FINDINGS
from rtgen.compiler.frontends.eds.rules import RULES
from rtgen.compiler.inspection.models import inspect, tree
from rtgen.compiler.project import load as load_project
from rtgen.compiler.project import output

ROOT = Path(__file__).parents[2]

_CODES = {rule.code for rule in RULES}
_MAX_CHARACTERS = 200_000
_VALUES = """
    0 1 -1 2 7 8 9 010 0x 0x7 0x07 0x9 0x0005 0x0006 0x0008 0x0009 0x000A 0x0040 0x00A0 0xFF 255 256
    300 0x60000108 0x00050008 0xFFFFFFFF 0x100000000 1e39 0.5 .5f nan inf -0 1A00h $NODEID
    $NODEID+0x180 0x180+$NODEID $NODEID+$NODEID $NODEID+ + - $ ro rw const R UNKNOWN VAR RECORD
    UNSIGNED8 true 99999999999999999999999999999999 [ ] = ; # é \u2028 \x0b \x85
    1,2 ABCDEF 01-01-2026
""".split()
_SECTIONS = """
    2000 2000sub0 2000sub1 2001sub0 2001sub1 2001subFF 2001sub100 2001sub01 0x2000 A0 A0sub1 00A0
    1400 1600 1600sub0 1600sub40 1800 1A00 1A00sub1 2001Name 2001Value 2001Denotation
    2000ObjectLinks FileInfo DeviceInfo DeviceComissioning DummyUsage Comments
    MandatoryObjects SupportedModules
    ConnectedModules M1ModuleInfo M1Fixed2005 M1Fixed2005sub0 M1SubExt2001
    M1SubExt6000 Tools Tool1 FFFF
""".split()
_KEYS = """
    ParameterName ObjectType DataType AccessType DefaultValue LowLimit HighLimit PDOMapping
    SubNumber CompactSubObj ObjFlags ParameterValue Denotation Factor Unit NrOfEntries
    SupportedObjects Lines
    NodeID Baudrate Granularity CompactPDO NrOfRXPDO NrOfTXPDO VendorNumber Count ObjExtend 1 2 3
    Dummy0005 Line1 BaudRate_500 paramtername
""".split()


class EdsTarget:
    """The golden cases, and this project's own descriptions, broken and mixed."""

    def __init__(self, folder: Path) -> None:
        self._folder = folder

    def make(self, number: int) -> bytes:
        """Return lines of a description with some changed, doubled, exchanged or left out."""
        chance = Random(number)
        lines = list(chance.choice(_texts()))
        if chance.random() < 0.5:
            lines = lines[chance.randrange(len(lines)) :][: chance.randrange(1, 80)]
        for _ in range(log_uniform(1, 30, chance.random())):
            _change(chance, lines)
        text = chance.choice(["\n", "\n", "\r\n", "\r"]).join(lines)[:_MAX_CHARACTERS]
        data = text.encode(chance.choice(["utf-8", "utf-8", "utf-16", "utf-8-sig"]))
        if chance.random() < 0.1 and data:
            at = chance.randrange(len(data))
            data = data[:at] + chance.randbytes(2) + data[at + chance.randrange(3) :]
        return data

    def check(self, number: int, data: bytes) -> Iterator[str]:
        """Read the description as an EDS or a DCF, for a node or for none."""
        path = self._folder / ("input.dcf" if number % 3 == 0 else "input.eds")
        path.write_bytes(data)
        node_id = None if number % 2 else 1 + number % 127
        result = load([path], root=self._folder, node_id=node_id)
        lines = result.sources[path.as_posix()].split("\n")
        _hold(result.diagnostics, lines)
        failed = has_errors(result.diagnostics)
        if failed == bool(result.model.devices):
            raise ViolationError("a device and an error, or neither")
        report(result.diagnostics, result.sources)
        json.dumps(inspect(result.model, result.diagnostics), allow_nan=False)
        tree(result.model)
        yield "errors" if failed else "read"
        yield from {d.code for d in result.diagnostics}


def _hold(found: tuple[Diagnostic, ...], lines: list[str]) -> None:
    """Check the guarantees for findings."""
    if len(found) > 3 * MAX_FINDINGS + 3:
        raise ViolationError(f"{len(found)} findings")
    for d in found:
        span = d.span
        if d.code not in _CODES or span is None:
            raise ViolationError(f"{d.code} without a rule or a place")
        if not 1 <= span.line <= span.end_line <= max(len(lines), 1):
            raise ViolationError(f"{d.code} in line {span.line} of {len(lines)}")
        if not 1 <= span.column <= len(lines[span.line - 1]) + 1:
            raise ViolationError(f"{d.code} in column {span.column}")


@cache
def _texts() -> list[list[str]]:
    folders = (ROOT / "tests/golden/eds_errors", ROOT / "specs")
    files = sorted(p for f in folders for p in f.rglob("*.*") if _is_description(p))
    texts = [p.read_bytes().decode("utf-8", "replace").splitlines() for p in files]
    return [lines for lines in texts if lines]


def _is_description(path: Path) -> bool:
    return path.suffix in (".eds", ".dcf")


def _change(chance: Random, lines: list[str]) -> None:
    at = chance.randrange(len(lines) + 1)
    line = lines[at] if at < len(lines) else ""
    key, equals, value = line.partition("=")
    match chance.randrange(8):
        case 0:
            lines.insert(at, f"[{chance.choice(_SECTIONS)}]")
        case 1:
            lines.insert(at, f"{chance.choice(_KEYS)}={chance.choice(_VALUES)}")
        case 2 if equals:
            lines[at] = f"{key}={chance.choice(_VALUES)}"
        case 3 if equals:
            lines[at] = f"{chance.choice(_KEYS)}={value}"
        case 4:
            del lines[at : at + chance.randrange(1, 4)]
        case 5 if lines:
            other = chance.randrange(len(lines))
            lines[at:at] = lines[other : other + log_uniform(1, 40, chance.random())]
        case 6 if line:
            place = chance.randrange(len(line))
            lines[at] = line[:place] + chance.choice(_VALUES) + line[place + 1 :]
        case 7:
            lines.insert(at, "[" + line.strip("[]") + "]")


class ComponentsTarget(EdsTarget):
    """Generates and imports the components of each description, alone and as a node of a bus."""

    def check(self, number: int, data: bytes) -> Iterator[str]:
        """Generate the components of a description without errors, and create instances."""
        name, ports = f"fuzzed{number}", ("pdo", "object")[number % 2]
        root = self._folder / name
        (root / "eds").mkdir(parents=True, exist_ok=True)
        path = root / "eds/input.eds"
        path.write_bytes(data)
        if has_errors(load([path], root=root).diagnostics):
            yield "errors"
            return
        (root / "rtgen.toml").write_text(_PROJECT.format(name=name))
        (root / "eds/bus.toml").write_text(_BUS.format(ports=ports))
        with chdir(root):
            project = load_project()
            run = compile_project(project)
            if run.failed:
                yield "refused"
                return
            output.write(project, run)
            for factory in _factories(root, name):
                factory("Fuzzed0")
        yield "made"


_PROJECT = """[sources]
paths = ["eds"]
[output]
package = "{name}"
skeletons = "src/{name}nodes"
"""
_BUS = """[bus]
name = "one"
bit_rate = 500
[device.input]
eds = "input.eds"
ports = "{ports}"
[node.one]
device = "input"
id = 5
"""


def _factories(root: Path, package: str) -> list[Callable[[str], object]]:
    """Return the factories of the components, after the import of all modules."""
    folders = [str(root / "generated"), str(root / "src")]
    sys.path[:0] = folders
    invalidate_caches()
    try:
        found = import_module(package)
        for module in walk_packages(found.__path__, f"{package}."):
            import_module(module.name)
        targets = output.component_types(root / "generated").factories.values()
        return [
            getattr(import_module(module), name)
            for module, _, name in (target.partition(":") for target in targets)
        ]
    finally:
        del sys.path[: len(folders)]
        for module_name in [n for n in sys.modules if n.startswith(package)]:
            del sys.modules[module_name]
