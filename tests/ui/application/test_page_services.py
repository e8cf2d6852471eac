"""Forms of operations, and calls to a board, in a real browser."""

from __future__ import annotations

import re
from pathlib import Path
from typing import Any

import pytest
from ui_bench import ROOT

pytestmark = [pytest.mark.slow, pytest.mark.peer]


@pytest.fixture(scope="module")
def shown() -> tuple[Path, None]:
    return ROOT / "specs/tecs/rh3_board.xml", None


@pytest.fixture
def services(page: Any) -> Any:
    """Return the page with the operations of the board's marshaller."""
    chooser = page.get_by_role("combobox", name="Component")
    chooser.select_option("MotorBoardMarshaller0")
    page.get_by_role("tab", name="Services").click()
    return page


@pytest.mark.nightly
def test_a_function_is_called_and_its_octets_shown(services: Any) -> None:
    services.get_by_role("button", name="Call identify of").click()
    result = services.get_by_role("status", name="Result of identify")
    result.get_by_text("RH3 motor board, simulated", exact=True).wait_for()
    request = result.get_by_role("row", name="67 2a 00 01 5a 3c")
    assert request.get_by_text("sMotorBoard.identify").is_visible()
    reply = result.get_by_role("row", name="56 1e 00 00")
    text = reply.inner_text().replace("\xa0", " ")
    assert "name = RH3 motor board, simulated" in text


@pytest.mark.nightly
def test_arguments_and_results_stay_while_another_view_is_shown(services: Any) -> None:
    fields = services.get_by_role("form", name="setLimits").get_by_role("textbox")
    before = fields.nth(1).input_value()
    services.get_by_role("button", name="Call identify of").click()
    result = services.get_by_role("status", name="Result of identify")
    result.get_by_text("RH3 motor board, simulated", exact=True).wait_for()
    fields.nth(1).fill("12")
    services.get_by_role("tab", name="Values").click()
    result.wait_for(state="detached")
    services.get_by_role("tab", name="Services").click()
    result.get_by_text("RH3 motor board, simulated", exact=True).wait_for()
    assert fields.nth(1).input_value() == "12"
    fields.nth(1).fill(before)


@pytest.mark.nightly
def test_a_hundred_calls_are_a_histogram(services: Any) -> None:
    times = services.get_by_label("Times identify is called")
    times.fill("100")
    times.press("Enter")
    result = services.get_by_role("status", name="Result of identify")
    result.get_by_role("img", name="Round trips of 100 calls").wait_for()
    assert re.search(
        r"100 calls: mean \d.* [µm]s, spread .*, least .*, most", result.inner_text()
    )
    times.fill("1")


@pytest.mark.nightly
def test_arguments_are_checked_before_they_are_sent(services: Any) -> None:
    form = services.get_by_role("form", name="setLimits")
    fields = form.get_by_role("textbox")
    assert fields.count() == 2
    fields.nth(0).fill("fast")
    fields.nth(0).press("Enter")
    reason = form.get_by_role("alert").filter(has_text="is not a number")
    reason.wait_for()
    assert fields.nth(0).get_attribute("aria-describedby") == reason.get_attribute("id")
    assert fields.nth(1).get_attribute("aria-invalid") is None
    fields.nth(0).fill("10")
    reason.wait_for(state="detached")
    result = services.get_by_role("status", name="Result of setLimits")
    fields.nth(1).fill("50")
    fields.nth(1).press("Enter")
    result.get_by_text("40 24 00 00 00 00 00 00 40 49 00 00").wait_for()


@pytest.mark.nightly
def test_round_trips_are_a_histogram(services: Any) -> None:
    services.get_by_role("tab", name="Boards").focus()
    services.keyboard.press("Enter")
    services.get_by_role("img", name="Round trips of").wait_for()
    services.get_by_label("Function").select_option("sMotorBoard.identify")
    calls = services.get_by_role("table", name="Calls to the board")
    calls.get_by_text("sMotorBoard.drive").first.wait_for(state="detached")
    calls.get_by_text("sMotorBoard.identify").first.wait_for()
    assert services.get_by_role("table", name="Calls to the board").is_visible()
