"""Devices with clashing names and unusual mappings are generated like any other."""

from __future__ import annotations

import os
import subprocess
import sys
from pathlib import Path

import black
import programs
import pytest
from eds_files import WIDTHS, Thing, eds, entry
from msgspec.structs import replace
from type_checkers import check_by_mypy

from rtgen.compiler.compilation import compile_project
from rtgen.compiler.frontends.eds import load as load_eds
from rtgen.compiler.kit.resources import idl_file
from rtgen.compiler.project import load, output
from rtgen.compiler.project.compilation import Compilation
from rtgen.compiler.typemap.canopen.ports import DevicePorts

NAMES = (
    *("class", "None", "match", "type", "print", "len", "int", "str", "bytes", "list"),
    *("super", "self", "cls", "property", "tuple", "object", "Exception", "ord", "chr"),
    *("RTC", "CANopen", "CORBA", "Time", "tm", "sdo", "Octets", "ObjectAccess", "Odd"),
    *("Tpdo1", "rpdo2", "TimedShort", "SdoAbort", "module", "sequence", "any", "octet"),
    *("config", "profile", "networks", "description", "objects", "node", "state"),
    *("interface", "channel", "network", "node_id", "now", "network", "value", "data"),
    *("get", "set", "read", "write", "struct", "error", "_pdo", "codecs", "Any"),
    *("ClassVar", "annotations", "Struct", "field", "to_cdr", "IntEnum", "Final"),
    *(
        "1st",
        "ümlaut",
        "\u65e5\u672c\u8a9e",
        "a*/b",
        "a\\",
        '"quoted"',
        "{brace}",
        "%s",
    ),
    *("dup", "Dup", "dup!", "//c", "#pragma once", "@x", "--", "...", "x" * 180),
)

OTHERS = {0x0009: 64, 0x000A: 32, 0x000B: 48, 0x000F: 40, 0x0012: 40, 0x0040: 8}
"""Types without a width of their own, and how many bits of them are mapped."""

CODES = {**WIDTHS, **OTHERS}

BUS = """
[bus]
bit_rate = 1000
name = "odd_bus"
[device.names]
eds = "names.eds"
name = "NamesApart"
ports = "object"
parameters = [{numbers}]
operations = [{numbers}]
[device.types]
eds = "types.eds"
name = "TypesApart"
ports = "object"
parameters = ["2001", "2003", "2007"]
[device.types.factors]
"2003" = -0.25
"2007" = 3.0
[device.types.units]
"2003" = "\\"*/ %s <&>"
[device.scaled]
eds = "types.eds"
name = "TypesScaled"
[device.scaled.factors]
"2001" = 0.5
"2003" = -0.25
"2007" = 3.0
[node.one]
device = "names"
id = 1
"""


def names() -> str:
    """Return a device with all the names, four of them in a PDO, both ways."""
    things = [Thing(name) for name in NAMES]
    entries = [entry(0x2000 + place, 16) for place in range(len(things))]
    pdos = {n // 4 + 1: entries[n : n + 4] for n in range(0, len(entries), 4)}
    return eds(things, pdos, pdos)


def types() -> str:
    """Return a device with all types, and difficult mappings."""
    codes = list(CODES)
    things = [
        Thing(f"T {code:02X}", code, default="" if code in OTHERS else "0")
        for code in codes
    ]
    pdos = {
        place + 1: [entry(0x2000 + place, CODES[code])]
        for place, code in enumerate(codes)
    }
    pdos[40] = [
        *(entry(5, 3), entry(0x2000, 1), entry(0x2001, 4), entry(0x2004, 3)),
        *(entry(0x2002, 9), entry(1, 4)),
    ]
    pdos[41] = [entry(0x2004, 8)] * 3
    pdos[42] = [entry(5, 8)]
    pdos[43] = [entry(0x2003, 32)] * 3
    pdos[44] = [entry(0x2000, 1), entry(0x2000 + codes.index(9), 16)]
    pdos[45] = [entry(0x2777, 16), entry(0x2003, 32)]
    return eds(things, pdos, pdos)


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Return the folder of the project."""
    root = tmp_path_factory.mktemp("odd")
    (root / "rtgen.toml").write_text(
        '[sources]\npaths = ["eds"]\n'
        '[output]\npackage = "odd"\nskeletons = "src/oddnodes"\n'
    )
    here = root / "eds"
    here.mkdir()
    one = eds([Thing("a")], {1: [entry(0x2000, 16)]})
    for name, text in {
        "names.eds": names(),
        "names_again.eds": names(),
        "types.eds": types(),
        "no_pdos.eds": eds([Thing("a")]),
        **{f"{stem}.eds": one for stem in ("class", "123", "Ünï-cödé", "module")},
        "bus.toml": BUS.replace(
            "{numbers}", ", ".join(f'"{0x2000 + n:04X}"' for n in range(len(NAMES)))
        ),
    }.items():
        (here / name).write_text(text, encoding="utf-8")
    return root


@pytest.fixture(scope="module")
def made(folder: Path) -> Compilation:
    """Generate and write the files."""
    with pytest.MonkeyPatch.context() as patch:
        patch.chdir(folder)
        project = load()
        run = compile_project(project)
        assert not run.failed, run.diagnostics
        output.write(project, run)
    return run


@pytest.mark.sampled(0)
def test_what_is_left_out_is_reported(made: Compilation) -> None:
    reported = [d for d in made.diagnostics if d.code == "EDS0802"]
    assert {d.message.partition(": ")[2] for d in reported} == {
        "96 bits; a PDO has up to 64",
        "T_09 does not begin and end at an octet",
    }


@pytest.mark.nightly
def test_everything_is_in_blacks_form(made: Compilation) -> None:
    mode = black.Mode()
    for artifact in made.artifacts:
        if artifact.path.endswith(".py") and len(artifact.text) < 20_000:
            formatted = black.format_str(artifact.text, mode=mode)
            assert artifact.text == formatted, artifact.path


def test_everything_is_imported_and_made(folder: Path, made: Compilation) -> None:
    """Import each module, and create each component."""
    code = (
        "import importlib, json, pkgutil, odd\n"
        "for each in pkgutil.walk_packages(odd.__path__, 'odd.'):\n"
        "    importlib.import_module(each.name)\n"
        "manifest = json.load(open('generated/.rtgen.json'))\n"
        "for name, target in manifest['factories'].items():\n"
        "    module, _, made = target.partition(':')\n"
        "    print(getattr(importlib.import_module(module), made)(name))\n"
    )
    path = os.pathsep.join([str(folder / "generated"), str(folder / "src")])
    done = subprocess.run(
        [sys.executable, "-c", code],
        cwd=folder,
        env=os.environ | {"PYTHONPATH": path},
        capture_output=True,
        text=True,
        check=False,
    )
    assert done.returncode == 0, done.stderr
    assert len(done.stdout.splitlines()) == 2 * 9 + 1


@pytest.mark.nightly
def test_mypy_strict(folder: Path, made: Compilation) -> None:
    search = [folder / "generated", folder / "src"]
    check_by_mypy([folder / "generated/odd", folder / "src"], search)


def test_omniidl_reads_the_idl(folder: Path, made: Compilation) -> None:
    here = folder / "generated/odd/canopen"
    shipped = {idl_file(name).parent for name in ("BasicDataType.idl", "Canopen.idl")}
    included = [f"-I{each}" for each in sorted(shipped)]
    for file in sorted(here.glob("*/*.idl")):
        done = subprocess.run(
            [programs.omniidl(), "-bdump", *included, str(file)],
            capture_output=True,
            check=False,
        )
        assert (done.returncode, done.stderr) == (0, b""), file.name


@pytest.mark.nightly
@pytest.mark.slow
def test_the_order_of_files_does_not_matter(folder: Path, made: Compilation) -> None:
    """Each file is the same if the sources are read in reverse order."""
    with pytest.MonkeyPatch.context() as patch:
        patch.chdir(folder)
        project = load()
        again = compile_project(
            replace(project, sources=tuple(reversed(project.sources)))
        )
    texts = {a.path: a.text for a in again.artifacts}
    of_devices = [a for a in made.artifacts if "/canopen/" in a.path]
    for artifact in of_devices:
        assert texts[artifact.path] == artifact.text


@pytest.mark.sampled(0)
def test_as_many_pdos_as_there_can_be(tmp_path: Path) -> None:
    things = [Thing(f"v{n}") for n in range(512)]
    pdos = {n + 1: [entry(0x2000 + n, 16)] for n in range(512)}
    path = tmp_path / "many.eds"
    path.write_text(eds(things, pdos, pdos))
    [device] = load_eds([path], root=tmp_path).model.devices
    ports = DevicePorts(device)
    assert len(ports.samples) == 1024
    assert ports.refused == []
    assert {s.name for s in ports.samples} >= {"tpdo512", "rpdo512"}
