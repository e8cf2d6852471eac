"""Names of a recording are data in every output of `rtgen log`."""

from __future__ import annotations

import csv
import json
from pathlib import Path
from xml.etree import ElementTree

import pytest

from refrobots.rtc import TimedLong
from rtgen.cli import run
from rtgen.runtime import (
    RTC_OK,
    Component,
    ComponentProfile,
    ReturnCode_t,
    SimulatedClock,
    System,
)
from rtgen.tools.recording.mcap_writer import McapWriter
from rtgen.tools.recording.recorder import Recorder

NAMES = (
    "</title><script>PWNED()</script>",
    "]]>PWNED<![CDATA[",
    "-->PWNED<!--",
    "&PWNED;",
    '" onload="PWNED()',
    "'); PWNED(); x = ('",
    "{{ PWNED }}",
    "$\\PWNED$",
    '=PWNED(),"PWNED"',
    "PWNED\x1b[2J\x07",
    "\u202ePWNED\u202c",
    "é ü 漢字 PWNED 🤖",
)


class Counter(Component):
    """Counts."""

    profile = ComponentProfile("Counter")

    def __init__(self, instance_name: str) -> None:
        super().__init__(instance_name)
        self.count = self.add_out_port("count", TimedLong)

    def on_execute(self, ec_id: int) -> ReturnCode_t:
        self.count.write(TimedLong(data=1))
        return RTC_OK


def recorded(folder: Path, name: str) -> Path:
    file = folder / "run.mcap"
    with McapWriter(file, "none") as writer, System(SimulatedClock()) as system:
        system.add(Counter(name), 1000.0)
        system.activate(name)
        recorder = Recorder(system, writer)
        system.run(3_000_000)
        recorder.end(through=False)
    return file


def tags(svg: Path) -> set[str]:
    return {element.tag for element in ElementTree.parse(svg).iter()}


@pytest.mark.sampled(3)
@pytest.mark.parametrize("name", NAMES, ids=map(ascii, NAMES))
def test_names_stay_names(
    name: str, tmp_path: Path, capfd: pytest.CaptureFixture[str]
) -> None:
    file = str(recorded(tmp_path, name))
    value = ["--", f"{name}.count"]

    assert run(["log", "info", "--json", file]) == 0
    printed = json.loads(capfd.readouterr().out)
    assert f"{name}.count" in {source["of"] for source in printed["sources"]}

    table = tmp_path / "values.csv"
    assert run(["log", "csv", file, "-o", str(table), *value]) == 0
    with table.open(encoding="utf-8", newline="") as stream:
        head, *rows = csv.reader(stream)
    assert head == ["t", f"{name}.count"]
    assert {len(row) for row in rows} == {2}

    pytest.importorskip("matplotlib")
    picture = tmp_path / "values.svg"
    assert run(["log", "plot", file, "-o", str(picture), *value]) == 0
    assert not any("script" in tag.lower() for tag in tags(picture))
    assert not any(
        key.rpartition("}")[2].startswith("on")
        for element in ElementTree.parse(picture).iter()
        for key in element.attrib
    )
