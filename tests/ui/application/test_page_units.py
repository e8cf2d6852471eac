"""Units of values on the page: each number has its member's own."""

from __future__ import annotations

from typing import Any

import pytest

pytestmark = [pytest.mark.slow, pytest.mark.peer]

LABELS = """plot =>
    [...plot.querySelectorAll(".u-legend .u-label")].map(each => each.textContent)"""
"""The labels of a plot's curves."""


def test_each_number_has_the_unit_of_its_member(page: Any) -> None:
    page.get_by_role("combobox", name="Component").select_option("Navigation0")
    page.get_by_role("tab", name="Values").click()
    path = page.get_by_role("region", name="Navigation0.path")
    plots = path.get_by_role("img", name="Values over time")
    plots.last.locator(".uplot").wait_for()
    rows = {
        row.split("\t")[0]: row.split("\t")[-1].strip()
        for row in path.locator("tbody tr").all_inner_texts()
    }
    assert rows["type"] == rows["coordinate"] == ""
    assert (rows["x"], rows["theta"]) == ("m", "rad")
    assert (rows["v"], rows["w"]) == ("m/s", "rad/s")
    labels = [label for plot in plots.all() for label in plot.evaluate(LABELS)]
    assert sorted(labels) == sorted(
        [
            *("type", "coordinate", "x [m]", "y [m]", "r [m]"),
            *("theta [rad]", "v [m/s]", "w"),
        ]
    )


def test_curves_of_one_unit_have_it_at_their_axis(page: Any) -> None:
    page.get_by_role("combobox", name="Component").select_option("Odometry0")
    page.get_by_role("tab", name="Values").click()
    angles = page.get_by_role("region", name="RefHardRh30.OutWheelAngle")
    plot = angles.get_by_role("img", name="Values over time")
    plot.locator(".uplot").wait_for()
    labels = plot.evaluate(LABELS)
    assert labels == ["data[0]", "data[1]"]
