"""Python generated from accepted definitions: it imports, round-trips, and type-checks.

The packages of many inputs are in one folder, so mypy checks all of them in one run.
"""

from __future__ import annotations

import shutil
import sys
import tempfile
import traceback
from collections.abc import Callable, Iterator
from contextlib import chdir, contextmanager
from importlib import import_module, invalidate_caches
from pathlib import Path
from pkgutil import walk_packages
from random import Random
from types import ModuleType

import octets
from cdl import CdlTarget
from doors.mixing import ROOT
from generated import forgotten_types
from idl_target import HELPERS

from rtgen import api
from rtgen.compiler.backends import Options, Owner
from rtgen.compiler.diagnostics import InputError, has_errors
from rtgen.compiler.model.tecs import (
    Signature,
    TecsDeclaration,
    TecsStruct,
    TecsTypedef,
)
from rtgen.tools.components.adopted import adopted
from rtgen.tools.components.component_text import component_idl

sys.path.append(str(ROOT / "tests"))

from type_checkers import check_by_mypy

_PROFILE_TYPES = ROOT / "specs/idl/ExtendedDataTypes.idl"
_TYPES = 2
"""Number of types of a package whose values are encoded and decoded."""
_CHANGES = 10
_JOINS = 4
_JOIN = """{1}celltype tFuzzedServer{2} {{ entry {0} eServer; }};
[active] celltype tFuzzedClient{2} {{ call {0} cServer; }};
cell tFuzzedServer{2} FuzzedServer{2} {{}};
cell tFuzzedClient{2} FuzzedClient{2} {{
  [through(RTCPlugin,"")] cServer = FuzzedServer{2}.eServer;
}};
"""


class Packages:
    """A folder with the packages of inputs; the name of a package is that of its input."""

    def __init__(self, folder: Path) -> None:
        self._folder = folder
        folder.mkdir(exist_ok=True)
        self.failures: dict[str, str] = {}
        """Tracebacks, and messages of mypy, by the names of inputs."""

    def add(self, name: str, door: str, data: bytes) -> bool:
        """Generate the package of a door's input; return whether there is anything to generate."""
        with tempfile.TemporaryDirectory() as scratch:
            try:
                made = self._generate(name, _SOURCES[door](Path(scratch), data))
                if made:
                    self._import(name)
            except InputError:  # the file is no definition at all
                return False
            except Exception:  # the defect that is looked for
                self.failures[name] = traceback.format_exc()
                return True
        return made

    def check_types(self) -> None:
        """Check all packages by mypy."""
        packages = [p for p in self._folder.iterdir() if p.is_dir()]
        if packages:
            try:
                check_by_mypy(sorted(packages), [self._folder, ROOT / "src"])
            except AssertionError as error:
                for line in str(error).splitlines():
                    name = line.partition(f"{self._folder.name}/")[2].partition("/")[0]
                    name = name.removesuffix("_nodes")
                    self.failures[name] = f"{self.failures.get(name, '')}{line}\n"

    def _generate(self, name: str, sources: list[Path]) -> bool:
        if not sources:
            return False
        folder = sources[0].parent
        with chdir(folder):
            read = api.read(sources, include=[folder], lowered=True)
            if has_errors(read.diagnostics):
                return False
            emission = api.emit(read.model, options=_options(name))
        if has_errors(emission.diagnostics):
            return False
        modules = [a for a in emission.artifacts if a.path.endswith(".py")]
        for artifact in modules:
            below = self._folder
            if artifact.owner is Owner.USER:
                below /= f"{name}_nodes"
                below.mkdir(exist_ok=True)
                (below / "__init__.py").touch()
            path = below / artifact.path
            path.parent.mkdir(parents=True, exist_ok=True)
            path.write_text(artifact.text, encoding="utf-8")
        return bool(modules)

    def _import(self, name: str) -> None:
        """Import all modules, and encode and decode values of some types."""
        chance = Random(name)
        packages = (name, f"{name}_nodes")
        with forgotten_types(), _imported(self._folder, packages) as modules:
            found = [t for module in modules for t in octets.types(module)]
            for type_ in chance.sample(found, min(len(found), _TYPES)):
                for encoding in octets.encodings(type_):
                    list(octets.explore(encoding, chance, _CHANGES))


def _options(name: str) -> Options:
    """Return the options of a package, which the name of its input decides."""
    chance = Random(name)
    return Options(
        name,
        f"{name}_nodes",
        "0",
        representation=chance.choice(("cdr", "xcdr2")),
        extensibility=chance.choice(("final", "appendable", "mutable")),
        lazy=chance.random() < 0.2,
    )


@contextmanager
def _imported(folder: Path, packages: tuple[str, ...]) -> Iterator[list[ModuleType]]:
    """Import all modules of packages, and remove them from `sys.modules` afterwards."""
    sys.path.insert(0, str(folder))
    invalidate_caches()
    try:
        modules = []
        for name in packages:
            if (folder / name).is_dir():
                package = import_module(name)
                inside = walk_packages(package.__path__, f"{name}.")
                modules += [package, *(import_module(each.name) for each in inside)]
        yield modules
    finally:
        sys.path.remove(str(folder))
        for name in [n for n in sys.modules if n.partition(".")[0] in packages]:
            del sys.modules[name]


def _in_file(name: str) -> Callable[[Path, bytes], list[Path]]:
    def write(folder: Path, data: bytes) -> list[Path]:
        path = folder / name
        path.parent.mkdir(parents=True, exist_ok=True)
        path.write_bytes(data)
        return [path]

    return write


def _idl(folder: Path, data: bytes) -> list[Path]:
    for name, text in HELPERS.items():
        (folder / name).write_bytes(text)
    return _in_file("input.idl")(folder, data)


def _cdl(folder: Path, data: bytes) -> list[Path]:
    """Join each signature of the file through the plug-in, or the first that can be joined."""
    CdlTarget(folder)
    found = _declarations(folder, _in_file("input.cdl")(folder, data))
    signatures = [s for s in found if isinstance(s, Signature) and s.functions]
    return _joined(folder, [("::".join(s.name), "") for s in signatures[:_JOINS]])


def _c_header(folder: Path, data: bytes) -> list[Path]:
    """Join a signature with each type of the header, or the first that can be joined."""
    _in_file("input.h")(folder, data)
    unit = _in_file("input.cdl")(folder, b'import_C("input.h");\n')
    found = _declarations(folder, unit)
    types = [t for t in found if isinstance(t, (TecsStruct, TecsTypedef)) and t.from_c]
    signatures = []
    for number, type_ in enumerate(types[-_JOINS:]):
        name = "struct " * isinstance(type_, TecsStruct) + type_.name[-1]
        function = f"int32_t f( [in] const {name} *a, [out] {name} *b );"
        text = f"signature sFuzzed{number} {{ {function} }};\n"
        signatures.append((f"sFuzzed{number}", text))
    return _joined(folder, signatures)


def _declarations(folder: Path, sources: list[Path]) -> list[TecsDeclaration]:
    """Return the declarations of CDL, none if there are errors."""
    with chdir(folder):
        read = api.read(sources, include=[folder])
    if has_errors(read.diagnostics):
        return []
    return [
        declaration for unit in read.model.tecs for declaration in unit.declarations
    ]


def _joined(folder: Path, signatures: list[tuple[str, str]]) -> list[Path]:
    """Write joins of servers and clients of as many signatures, with their text, as can be."""
    if not signatures:
        return []
    for chosen in (signatures, *([each] for each in signatures)):
        parts = ['import("input.cdl");\n']
        parts += (_JOIN.format(name, text, n) for n, (name, text) in enumerate(chosen))
        sources = _in_file("joined.cdl")(folder, "".join(parts).encode())
        with chdir(folder):
            read = api.read(sources, include=[folder], lowered=True)
        if not has_errors(read.diagnostics):
            return sources
    return []


def _msg(folder: Path, data: bytes) -> list[Path]:
    kind = ("msg", "srv", "action")[data.count(b"---") % 3]
    return _in_file(f"fuzzed_msgs/{kind}/Input.{kind}")(folder, data)


def _profile(name: str) -> Callable[[Path, bytes], list[Path]]:
    def write(folder: Path, data: bytes) -> list[Path]:
        return [*_in_file(name)(folder, data), _PROFILE_TYPES]

    return write


def _adopt(folder: Path, data: bytes) -> list[Path]:
    [module] = _in_file("Input.py")(folder, data)
    with chdir(folder):
        found = adopted(module, [folder])
    if found.component is None:
        return []
    text = component_idl(found.model, found.component)
    return _in_file("adopted.idl")(folder, text.encode())


def _bus(folder: Path, data: bytes) -> list[Path]:
    for eds in (ROOT / "specs/canopen").glob("*.eds"):
        shutil.copy(eds, folder)
    return _in_file("input.toml")(folder, data)


_SOURCES: dict[str, Callable[[Path, bytes], list[Path]]] = {
    "idl": _idl,
    "cdl": _cdl,
    "c-header": _c_header,
    "eds": _in_file("input.eds"),
    "dcf": _in_file("input.dcf"),
    "msg": _msg,
    "adopt": _adopt,
    "bus": _bus,
    "rtc-xml": _profile("RTC.xml"),
    "rtc-yaml": _profile("RTC.yaml"),
}
"""Functions that write the files of an input and return the sources of its project, by door."""

DOORS = tuple(_SOURCES)
"""The doors of definitions from which Python is generated."""
