"""Units of values on the page: each number has its member's own."""

from __future__ import annotations

from typing import Any

import pytest
from ui_bench import select

pytestmark = [pytest.mark.nightly, pytest.mark.slow, pytest.mark.peer]


def test_each_number_has_the_unit_of_its_member(page: Any) -> None:
    select(page, "Navigation0")
    page.get_by_role("tab", name="Values").click()
    path = page.get_by_role("region", name="Navigation0.path")
    plots = path.get_by_role("img", name="Values over time")
    plots.last.locator(".uplot").wait_for()
    rows = {
        row.locator("th").inner_text(): row.locator("td").last.inner_text()
        for row in path.locator(".curves tbody tr").all()
    }
    lengths = dict.fromkeys(("x", "y", "r"), "m")
    others = {"theta": "rad", "v": "m/s", "w": "rad/s"}
    assert rows == {"type": "", "coordinate": "", **lengths, **others}


def test_each_unit_has_an_axis(page: Any) -> None:
    """There are two axes at most in a picture; curves of one unit share theirs."""
    select(page, "Odometry0")
    page.get_by_role("tab", name="Values").click()
    pose = page.get_by_role("region", name="Odometry0.OdometryPosition")
    plot = pose.get_by_role("img", name="Values over time")
    plot.locator(".uplot").wait_for()
    assert plot.count() == 1
    # Of the time, of metres on the left and of radians on the right.
    assert plot.locator(".u-axis").count() == 3
    angle = pose.get_by_role("row", name="heading").get_by_role("checkbox")
    angle.uncheck()
    plot.locator(".u-axis").nth(2).wait_for(state="detached")
    angle.check()
    plot.locator(".u-axis").nth(2).wait_for(state="attached")
