"""Each option of each command that names a file of a user, with files that nobody means to give.

The table below is compared with the commands: a new option for a file needs a row. A run draws some
of the files for each row; `RTGEN_BUDGET` multiplies them.
"""

from __future__ import annotations

import json
import os
import random
import re
import shutil
import socket
import sys
from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass
from pathlib import Path

import click
import pytest
import seeds
from limited_runs import Run, Runs
from patience import PATIENCE

from rtgen.cli import application
from rtgen.cli import run as run_command

pytestmark = [
    pytest.mark.random,
    pytest.mark.skipif(sys.platform != "linux", reason="limits and pipes of Linux"),
]

TRACES = Path(__file__).parents[2] / "golden" / "tecs" / "opaque_rpc_traces.json"


# Files


def a_pipe(path: Path) -> None:
    os.mkfifo(path)


def a_linked_pipe(path: Path) -> None:
    other = path.with_name(f"{path.name}.pipe")
    os.mkfifo(other)
    path.symlink_to(other.name)


def zeros(path: Path) -> None:
    path.symlink_to("/dev/zero")


def a_folder(path: Path) -> None:
    path.mkdir()


def a_socket(path: Path) -> None:
    with socket.socket(socket.AF_UNIX) as made:
        number = os.open(path.parent, os.O_RDONLY)
        made.bind(f"/proc/self/fd/{number}/{path.name}")
        os.close(number)


def a_circle(path: Path) -> None:
    path.symlink_to(path.name)


def eight_gigabytes(path: Path) -> None:
    with path.open("wb") as stream:
        stream.truncate(8 << 30)


def containing(octets: bytes) -> Callable[[Path], None]:
    def make(path: Path) -> None:
        path.write_bytes(octets)

    return make


NO_FILES = (a_pipe, a_linked_pipe, zeros, a_folder, a_socket, a_circle)
"""Commands do not even open them."""

CONTENTS: Mapping[str, bytes] = {
    "nothing": b"",
    "octets": bytes(range(256)) * 100,
    "brackets": b"(" * 10_000,
    "modules": b"module M {" * 10_000,
    "elements": b"<a>" * 10_000,
    "objects": b'[{"a":' * 5_000,
    "lists": b"a = " + b"[" * 10_000,
    "dashes": b"- " * 10_000,
    "a long line": b"a" * 3_000_000,
    "many lines": b"a\n" * 300_000,
}

FILES: Mapping[str, Callable[[Path], None]] = {
    **{each.__name__: each for each in (*NO_FILES, eight_gigabytes)},
    **{name: containing(octets) for name, octets in CONTENTS.items()},
}

NAMES: Mapping[str, str] = {
    "a name of other octets": "\udcff\udcfe",
    "a name with controls": "a\x1b[31m\nb",
    "a long name": "n" * 5_000,
    "a long path": "/".join(["n" * 200] * 25),
    "a null character": "a\0b",
    "no file": "gone",
}
"""Names; those that a file can have are those of a good one."""

IMPOSSIBLE = ("a long name", "a long path", "a null character")


# Options


@dataclass(frozen=True)
class Row:
    """A command line in which `@` is the file.

    `suffix` and `good` (a file of the project) are those of the file. `kind`: it is `read`,
    `written`, a `folder`, or just a `name`. `serves`: the command waits where the file is good.
    """

    words: str
    suffix: str = ""
    good: str = ""
    kind: str = "read"
    serves: bool = False


IDL, CDL = (".idl", "definitions/scaler.idl"), (".cdl", "definitions/arm.cdl")
EDS, BUS = (".eds", "definitions/motor.eds"), (".toml", "definitions/motor_bus.toml")
SYSTEM, TIMELINE = (".xml", "systems/demo.xml"), (".toml", "timeline.toml")
PROFILE = (".xml", "generated/demo/components/scaler/RTC.xml")
MCAP, LOG = (".mcap", "a.mcap"), (".log", "a.log")
RUN = "run systems/demo.xml --until 0.1"
REAL = f"{RUN} --clock real"
OFFLINE = "--interface virtual"
UI = "ui systems/demo.xml --port 0 --no-open"
ARM = "--cdl definitions/arm.cdl"
NODE = f"--connect virtual:0 --node 1 --timeout 0.1 --boot 0.1 {OFFLINE}"

ROWS: Mapping[str, tuple[Row, ...]] = {
    "generate paths": tuple(
        Row("generate @ -o out", *each) for each in (IDL, CDL, EDS, BUS, PROFILE)
    ),
    "generate output": (Row("generate definitions/scaler.idl -o @", kind="folder"),),
    "check paths": (Row("check @ -o out", *IDL), Row("check @ -o out", *CDL)),
    "check output": (Row("check definitions/scaler.idl -o @", kind="name"),),
    "docs paths": (Row("docs @ -o site", *CDL), Row("docs @ -o site", *SYSTEM)),
    "docs folder": (Row("docs -o @", kind="folder"),),
    "new base drives": (
        Row("new base Fresh @ --ros2", *EDS),
        Row("new base Fresh @ --ros2", *CDL),
    ),
    "new ros2-package systems": (Row("new ros2-package fresh --system @", *SYSTEM),),
    "new ros2-package folder": (
        Row("new ros2-package fresh --folder @", kind="folder"),
    ),
    "diff versions": (
        Row("diff @ definitions/scaler.idl", *IDL),
        Row("diff definitions/motor.eds @", *EDS),
        Row("diff @ systems/demo.xml", *SYSTEM),
    ),
    "lint paths": (Row("lint --fix @", *IDL), Row("lint @", *CDL), Row("lint @", *BUS)),
    "fmt paths": (Row("fmt @", *IDL), Row("fmt --check @", *CDL), Row("fmt @", *BUS)),
    "fmt stdin_filename": (Row("fmt - --stdin-filename @", ".idl", kind="name"),),
    "inspect paths": (
        Row("inspect @", *IDL),
        Row("inspect @ --json", *CDL),
        Row("inspect @", *EDS),
        Row("inspect @", *SYSTEM),
        Row("inspect @", ".yaml"),
    ),
    "run system": (
        Row("run @ --until 0.1", *SYSTEM),
        Row("run @ --until 0.1", ".yaml"),
    ),
    "run timeline_file": (Row(f"{RUN} --timeline @", *TIMELINE),),
    "run table": (Row(f"{RUN} --csv @", ".csv", kind="written"),),
    "run picture": (Row(f"{RUN} --plot @", ".svg", kind="written"),),
    "run log": (Row(f"{RUN} --log @", ".jsonl", kind="written"),),
    "run recorded": (Row(f"{RUN} --record @", ".mcap", kind="written"),),
    "run checkpoints": (Row(f"{RUN} --checkpoints @", kind="folder"),),
    "run activated": (
        Row(f"{REAL} --transport corba --activated @", kind="name"),  # warns
    ),
    "run transport_config": (
        Row(f"{REAL} --transport dds --transport-config @", ".xml"),
        Row(f"{REAL} --transport zenoh --transport-config @", ".json5"),
    ),
    "ui transport_config": (
        Row(
            "ui --port 0 --no-open --transport dds --transport-config @",
            ".xml",
            serves=True,
        ),
        Row(
            "ui --port 0 --no-open --transport zenoh --transport-config @",
            ".json5",
            serves=True,
        ),
    ),
    "ui systems": (Row("ui @ --port 0 --no-open", *SYSTEM, serves=True),),
    "ui buses": (Row(f"{UI} --bus @", *BUS, serves=True),),
    "ui recorded": (
        Row(f"{UI} --play --record @", ".mcap", kind="written", serves=True),
    ),
    "replay file": (Row("replay @", *MCAP),),
    "replay into": (Row("replay a.mcap --into @ --only Scaler1", *SYSTEM),),
    "replay log": (Row("replay a.mcap --log @", ".jsonl", kind="written"),),
    "replay recorded": (Row("replay a.mcap --record @", ".mcap", kind="written"),),
    "log info file": (Row("log info @", *MCAP),),
    "log cat file": (Row("log cat @", *MCAP),),
    "log play file": (Row("log play @ --rate 1000", *MCAP),),
    "log csv file": (Row("log csv @ Scaler0.state", *MCAP),),
    "log csv output": (
        Row("log csv a.mcap Scaler0.state -o @", ".csv", kind="written"),
    ),
    "log plot file": (Row("log plot @ Scaler0.state -o ../out.svg", *MCAP),),
    "log plot output": (
        Row("log plot a.mcap Scaler0.state -o @", ".svg", kind="written"),
    ),
    "log diff file": (Row("log diff @ a.mcap", *MCAP),),
    "log diff other": (Row("log diff a.mcap @", *MCAP),),
    "log export file": (Row("log export --ros2 @ ../bag", *MCAP),),
    "log export folder": (Row("log export --ros2 a.mcap @", kind="folder"),),
    "graph system": (Row("graph @", *SYSTEM), Row("graph @", ".yaml")),
    "graph output": (Row("graph systems/demo.xml -o @", ".svg", kind="written"),),
    "graph timeline_file": (Row("graph systems/demo.xml --timeline @", *TIMELINE),),
    "convert file": (
        Row("convert @ --to idl", *PROFILE),
        Row("convert @ --to yaml", *SYSTEM),
        Row("convert @ --to xml", ".yaml"),
        Row("convert @ --to xml", *IDL),
        Row("convert @", ".py"),
    ),
    "convert output": (Row("convert adopted.py -o @", kind="folder"),),
    "rpc list cdl": (Row("rpc list --cdl @", *CDL),),
    "rpc list named": (Row("rpc list @", *CDL),),
    "rpc call cdl": (Row("rpc call --cdl @ 127.0.0.1:1 sArm.off {}", *CDL),),
    "rpc check cdl": (Row("rpc check --cdl @ 127.0.0.1:1 sArm", *CDL),),
    "rpc encode cdl": (Row("rpc encode --cdl @ sArm.off --request {}", *CDL),),
    "rpc decode cdl": (Row("rpc decode --cdl @ sArm.off --request 00", *CDL),),
    "rpc serve cdl": (
        Row("rpc serve --cdl @ --signature sArm --port 0", *CDL, serves=True),
    ),
    "rpc serve script": (
        Row(
            f"rpc serve {ARM} --signature sArm --port 0 --script @",
            ".jsonl",
            serves=True,
        ),
    ),
    "rpc replay traces": (Row("rpc replay @", ".json", "traces.json"),),
    "can monitor bus_file": (Row(f"can monitor --for 0.1 --bus @ {OFFLINE}", *BUS),),
    "can monitor descriptions": (
        Row(f"can monitor --for 0.1 --eds 1=@ {OFFLINE}", *EDS),
    ),
    "can record bus_file": (
        Row(f"can record out/frames.log --for 0.1 --bus @ {OFFLINE}", *BUS),
    ),
    "can record descriptions": (
        Row(f"can record out/frames.log --for 0.1 --eds 1=@ {OFFLINE}", *EDS),
    ),
    "can record file": tuple(
        Row(f"can record @ --for 0.1 {OFFLINE}", suffix, kind="written")
        for suffix in (".log", ".asc", ".blf")
    ),
    "can replay file": (
        *(Row("can replay @ --decode", suffix) for suffix in (".asc", ".blf", ".trc")),
        Row("can replay @ --decode", *LOG),
        Row(f"can replay @ --at-once {OFFLINE}", *LOG),
    ),
    "can replay bus_file": (Row("can replay a.log --decode --bus @", *BUS),),
    "can replay descriptions": (Row("can replay a.log --decode --eds 1=@", *EDS),),
    "can plot record": (Row("can plot 182 --from @ -o ../out.svg", *LOG),),
    "can plot outputs": (
        Row("can plot 182 --from a.log -o @", ".csv", kind="written"),
    ),
    "can plot bus_file": (
        Row("can plot 182 --from a.log -o ../out.svg --bus @", *BUS),
    ),
    "can plot descriptions": (
        Row("can plot 182 --from a.log -o ../out.svg --eds 1=@", *EDS),
    ),
    "can send file": (Row(f"can send --file @ {OFFLINE}", *LOG),),
    "can send bus_file": (Row(f"can send 1#00 --bus @ {OFFLINE}", *BUS),),
    "can send descriptions": (Row(f"can send 1#00 --eds 1=@ {OFFLINE}", *EDS),),
    "can scan output": (
        Row(f"can scan --for 0.1 --eds 1 -o @ {OFFLINE}", ".eds", kind="written"),
    ),
    "can scan bus_file": (Row(f"can scan --for 0.1 --bus @ {OFFLINE}", *BUS),),
    "can scan descriptions": (Row(f"can scan --for 0.1 --eds 1=@ {OFFLINE}", *EDS),),
    "can sdo file": (
        Row(f"can sdo write 1 2000 --type domain --file @ --timeout 0.1 {OFFLINE}"),
    ),
    "can sdo bus_file": (
        Row(f"can sdo read 1 1000 --timeout 0.1 --bus @ {OFFLINE}", *BUS),
    ),
    "can sdo descriptions": (
        Row(f"can sdo read 1 1000 --timeout 0.1 --eds 1=@ {OFFLINE}", *EDS),
    ),
    "can timing file": (Row("can timing @", *BUS),),
    "can timing system": (
        Row("can timing definitions/motor_bus.toml --system @", *SYSTEM),
    ),
    "conformance file": (
        Row(f"conformance @ {NODE}", *EDS),
        Row("conformance @ --connect tcp:127.0.0.1:1 --signature sArm", *CDL),
        Row("conformance @ --connect corba:127.0.0.1:1/x --timeout 0.1", *PROFILE),
    ),
    "conformance junit": (
        Row(f"conformance definitions/motor.eds {NODE} --junit @", kind="written"),
    ),
    "conformance html": (
        Row(f"conformance definitions/motor.eds {NODE} --html @", kind="written"),
    ),
    **{
        f"ctl {verb.split()[0]} {option}": (Row(f"ctl {verb} {given}", *file),)
        for verb in (
            *("list", "show A0", "activate A0", "deactivate A0", "reset A0"),
            *("get A0", "set A0.a=1", "use A0 a", "call A0.p.o()", "watch --for 0.1"),
        )
        for option, given, file in (
            ("system", "--transport dds --wait 0.1 --system @", SYSTEM),
            (
                "transport_config",
                "--transport dds --wait 0.1 --partition x --transport-config @",
                (".xml", ""),
            ),
        )
    },
}
"""The rows for each command and parameter."""

FOLDERS = frozenset(("include",))
"""Parameters for folders that are only searched."""

_FILE = re.compile(r"FILE|PATH|FOLDER|DIR$|SYSTEM|TOML|OLD(?!=)|DIR\b")


def parameters(
    command: click.Command, context: click.Context
) -> Iterator[tuple[str, click.Parameter]]:
    """Yield the parameters of a command, and of those below it, with their names."""
    if isinstance(command, click.Group):
        for name in command.list_commands(context):
            inner = command.get_command(context, name)
            assert inner is not None
            below = click.Context(inner, info_name=name, parent=context)
            yield from parameters(inner, below)
        return
    path = context.command_path.removeprefix("rtgen ")
    for parameter in command.params:
        yield f"{path} {parameter.name}", parameter


def names_a_file(parameter: click.Parameter) -> bool:
    """Return whether a parameter is the path of a file or folder, as far as its help shows."""
    if isinstance(parameter.type, click.Path | click.File):
        return True
    metavar = parameter.metavar or ""
    return _FILE.search(metavar) is not None and parameter.name not in FOLDERS


def test_each_option_for_a_file_has_a_row() -> None:
    context = click.Context(application, info_name="rtgen")
    found = {
        name
        for name, parameter in parameters(application, context)
        if names_a_file(parameter)
    }
    assert found == set(ROWS)


# Runs


@pytest.fixture(scope="session")
def project(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Return a folder with good files of each kind."""
    folder = tmp_path_factory.mktemp("files")
    before = Path.cwd()
    os.chdir(folder)
    try:
        for words in ("new project demo -q", "new device Motor -q", "new board Arm -q"):
            assert run_command(words.split()) == 0
            os.chdir(folder / "demo")
        assert run_command(f"{RUN} --record a.mcap -q".split()) == 0
    finally:
        os.chdir(before)
    here = folder / "demo"
    (here / "timeline.toml").write_text('[[at]]\nt = 0.05\ndeactivate = "Scaler0"\n')
    (here / "a.log").write_text("(1.000000) can0 182#0011\n")
    (here / "adopted.py").write_text(
        "import OpenRTM_aist\n\nclass A(OpenRTM_aist.DataFlowComponentBase):\n    pass\n"
    )
    shutil.copy(TRACES, here / "traces.json")
    return here


@pytest.fixture(scope="session")
def runs(project: Path) -> Iterator[Runs]:
    with Runs(project, PATIENCE) as started:
        yield started


def state(folder: Path) -> dict[str, tuple[int, int, int]]:
    """Return the files of the user, without bytecode, each with its number, size and time."""
    kept = [folder / name for name in ("definitions", "systems", "src", "generated")]
    files = [file for each in kept for file in each.rglob("*")] + [*folder.glob("*.*")]
    found = {
        str(file): file.stat()
        for file in files
        if file.is_file()
        and not file.name.startswith("bad")
        and file.parent.name != "__pycache__"
    }
    return {name: (s.st_ino, s.st_size, s.st_mtime_ns) for name, s in found.items()}


def given(row: Row, file: str) -> list[str]:
    return [word.replace("@", file) for word in row.words.split()]


def check_end(result: Run, words: list[str]) -> None:
    """Check that a run ended by itself, and said so if it failed."""
    about = (words, result)
    assert result.code in (0, 1, 2, 3), about
    assert "internal error" not in result.errors, about
    assert "Traceback" not in result.errors, about
    if result.code in (2, 3):
        said = re.search(r"error\[[A-Z]+\d+\]|^Error: |^adopt: ", result.errors, re.M)
        assert said, about
    assert not re.search(r"[\x00-\x08\x0e-\x1f]", result.errors), about


def remove(path: Path) -> None:
    if path.is_dir() and not path.is_symlink():
        shutil.rmtree(path)
    else:
        path.unlink(missing_ok=True)


def kinds_of(row: Row) -> Iterator[str]:
    """Yield the kinds of files and names with which a row ends."""
    for kind in (*FILES, *NAMES):
        if not row.serves or kind in IMPOSSIBLE:
            yield kind
        elif row.kind == "written":
            if kind in {each.__name__ for each in NO_FILES} - {"zeros"}:
                yield kind
        elif kind not in CONTENTS and kind not in NAMES:
            yield kind


def drawn(name: str) -> list[tuple[Row, str]]:
    """Return a case of a parameter, another one in each run; all with a large budget."""
    draw = random.Random(f"{seeds.seed()} {name}")
    known = [(row, kind) for row in ROWS[name] for kind in kinds_of(row)]
    return draw.sample(known, min(len(known), seeds.budget(1)))


def try_file(project: Path, runs: Runs, row: Row, kind: str) -> None:
    file = project / f"bad{row.suffix}"
    FILES[kind](file)
    try:
        size = file.lstat().st_size
        words = given(row, file.name)
        result = runs.run(words)
        check_end(result, words)
        is_searched = kind == "a_folder" and row.words.startswith("fmt")
        if kind not in CONTENTS and row.kind == "read" and not is_searched:
            assert result.code in (2, 3), (words, kind, result)
        if row.kind == "read" and not row.words.startswith("fmt"):
            assert file.lstat().st_size == size, (words, kind)
    finally:  # else the next case waits for the other end of a pipe
        for each in project.glob("bad*"):
            remove(each)


def try_name(project: Path, runs: Runs, row: Row, kind: str) -> None:
    file = NAMES[kind] + row.suffix
    possible = kind not in (*IMPOSSIBLE, "no file")
    if possible and row.good:
        shutil.copy(project / row.good, project / file)
    words = given(row, file)
    result = runs.run(words)
    check_end(result, words)
    if kind in IMPOSSIBLE:
        assert result.code in (2, 3) or row.kind == "name", (words, result)
    elif possible or row.kind in ("written", "folder"):
        remove(project / file)


@pytest.mark.sampled(30)
@pytest.mark.parametrize("name", ROWS)
def test_a_command_ends_in_a_line_whatever_the_file_is(
    project: Path, runs: Runs, name: str
) -> None:
    before = state(project)
    for row, kind in drawn(name):
        (try_file if kind in FILES else try_name)(project, runs, row, kind)
    assert state(project) == before


@dataclass(frozen=True)
class Naming:
    """A file that names another one, `@`, and a command that reads both."""

    words: str
    file: str
    text: str
    suffix: str
    good: str


BUS_TEXT = """[bus]
bit_rate = 500
[device.m]
eds = "@"
[node.m]
device = "m"
id = 1
"""
PROJECT_TEXT = '[sources]\npaths = ["@"]\n'

NAMING: Mapping[str, Naming] = {
    "include of IDL": Naming("inspect via.idl", "via.idl", '#include "@"\n', *IDL),
    "import of CDL": Naming("inspect via.cdl", "via.cdl", 'import("@");\n', *CDL),
    "header of CDL": Naming(
        "lint via.cdl", "via.cdl", 'import_C("@");\n', ".h", "definitions/arm_types.h"
    ),
    "header of a board": Naming(
        "rpc list --cdl via.cdl",
        "via.cdl",
        'import_C("@");\n',
        ".h",
        "definitions/arm_types.h",
    ),
    "device of a bus": Naming("can timing via.toml", "via.toml", BUS_TEXT, *EDS),
    "device of a bus file": Naming("inspect via.toml", "via.toml", BUS_TEXT, *EDS),
    **{
        f"sources of {words.split()[0]}": Naming(
            words, "via/rtgen.toml", PROJECT_TEXT, *kind
        )
        for words, kind in (
            ("generate", IDL),
            ("check", CDL),
            ("lint", EDS),
            ("docs", CDL),
            ("inspect", BUS),
            ("fmt ..", IDL),
            ("diff --against HEAD", IDL),
            ("graph ../systems/demo.xml", IDL),
            ("run ../systems/demo.xml --until 0.1", CDL),
        )
    },
}


@pytest.mark.parametrize("name", NAMING)
def test_files_that_files_name(project: Path, runs: Runs, name: str) -> None:
    naming = NAMING[name]
    draw = random.Random(f"{seeds.seed()} {name}")
    known = [*FILES, *NAMES]
    for kind in draw.sample(known, min(len(known), seeds.budget(1))):
        place = project / naming.file
        place.parent.mkdir(exist_ok=True)
        other = NAMES.get(kind, "bad") + naming.suffix
        if kind in FILES:
            FILES[kind](place.parent / other)
        elif kind not in (*IMPOSSIBLE, "no file"):
            shutil.copy(project / naming.good, place.parent / other)
        written = other
        if naming.file.endswith(".toml"):
            written = json.dumps(os.fsencode(other).decode("latin-1"))[1:-1]
        text = naming.text.replace("@", written)
        place.write_text(text, encoding="utf-8", errors="surrogateescape")
        folder = str(place.parent)
        words = naming.words.split()
        result = runs.run(words, folder)
        check_end(result, words)
        if kind in (*IMPOSSIBLE, "no file") or (kind in FILES and kind not in CONTENTS):
            is_searched = kind == "a_folder" and "sources" in name
            is_other = words[0] in ("fmt", "diff")
            assert result.code in (2, 3) or is_searched or is_other, (kind, result)
        remove(place)
        if kind not in IMPOSSIBLE:
            remove(place.parent / other)
            remove(place.parent / f"{other}.pipe")
        if place.parent != project:
            shutil.rmtree(place.parent)  # with what was generated there
