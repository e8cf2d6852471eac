"""Connections and values that do not fit a component in C++, on every way in."""

from __future__ import annotations

from collections.abc import Iterator

import cpp_build
import devices
import pytest
from devices import Processes
from watching_page import Page

from rtgen.ui.errors import BAD_VALUE, NO_FIT
from rtgen.ui.protocol import ui

pytestmark = [*cpp_build.needed, pytest.mark.waits]

LONG = "type=IDL:RTC/TimedLong:1.0"


@pytest.fixture
def page(processes: Processes) -> Iterator[Page]:
    made = Page(processes.names)
    yield made
    made.session.close()


def test_a_page_does_not_connect_different_types(
    processes: Processes, page: Page
) -> None:
    processes.device("Base0")
    processes.device("Arm0", LONG)
    base, arm = page.found("/Base0").instance, page.found("/Arm0").instance
    source = ui.PortAddress(base, "measured")
    other, fitting = ui.PortAddress(arm, "command"), ui.PortAddress(base, "command")
    fits = {
        (each.port.instance, each.port.port): each.refused
        for each in page.done("ends", source).fits
    }
    why = "they have different types: RTC::TimedDoubleSeq and RTC::TimedLong"
    assert fits[arm, "command"] == why
    refused = page.result("wire", ui.Connect(source, other))
    assert (refused.done, refused.code, refused.message) == (False, NO_FIT, why)
    twice = page.result("wire", ui.Connect(source, ui.PortAddress(arm, "measured")))
    assert twice.message == "an OutPort is not connected to an OutPort"
    assert fits[base, "command"] == ""
    page.done("wire", ui.Connect(source, fitting))


VALUES = [
    ("many", "parameter 'size' cannot be 'many': it must be a decimal integer"),
    ("5000", "parameter 'size' cannot be '5000': its constraint is 0<=x<=1000"),
]


@pytest.mark.parametrize(("text", "why"), VALUES)
def test_a_page_does_not_set_such_a_value(
    processes: Processes, page: Page, text: str, why: str
) -> None:
    processes.device("Base0")
    name = page.found("/Base0").instance
    result = page.result("setting", ui.SetParameter(name, "", "size", text))
    assert (result.done, result.code) == (False, BAD_VALUE)
    assert result.message == f"{name}: {why}"
    page.done("setting", ui.SetParameter(name, "", "size", "7"))
    page.done("setting", ui.SetParameter(name, "", "label", text))


@pytest.mark.parametrize(("text", "why"), VALUES)
def test_a_run_does_not_set_such_a_value(
    processes: Processes, text: str, why: str
) -> None:
    processes.device("Base0")
    base = processes.device("Arm0")
    file = processes.folder / "values.xml"
    file.write_text(devices.system({"Base0": {"size": text}}))
    run = processes.run("--until", "0.1", system="values.xml")
    assert run.code() == 2
    assert f"error[SYS0004]: Base0: {why}" in run.text
    assert "activated" not in base.text


def test_a_run_names_a_text_and_its_code_set(processes: Processes) -> None:
    processes.device("Base0")
    processes.device("Arm0")
    file = processes.folder / "texts.xml"
    file.write_text(devices.system({"Base0": {"label": "日本"}}), encoding="utf-8")
    run = processes.run("--until", "0.1", system="texts.xml")
    assert run.code() == 2
    assert (
        "error[SYS0004]: Base0: '日本' has '日', and the other process has the code set "
        "ISO 8859-1; start it with -ORBnativeCharCodeSet UTF-8" in run.text
    )
