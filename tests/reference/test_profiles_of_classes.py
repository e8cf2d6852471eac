"""The profiles of generated classes are those of the RTC.xml files beside them."""

from __future__ import annotations

from importlib import import_module
from pathlib import Path
from xml.etree import ElementTree

import pytest

FOLDER = Path(__file__).parents[2] / "generated/refrobots/components"
FILES = sorted(FOLDER.glob("*/RTC.xml"))
RTC = "{http://www.openrtp.org/namespaces/rtc}"


@pytest.mark.parametrize("file", FILES, ids=lambda file: file.parent.name)
def test_profile(file: Path) -> None:
    info = ElementTree.parse(file).getroot().find(f"{RTC}BasicInfo")
    assert info is not None
    name = info.attrib[f"{RTC}name"]
    module = import_module(f"refrobots.components.{file.parent.name}")
    base = getattr(module, f"{name}Base", None) or getattr(module, name)
    profile = base.profile
    assert profile.type_name == name
    for key, value in (
        ("category", profile.category),
        ("vendor", profile.vendor),
        ("version", profile.version),
        ("description", profile.description),
        ("executionRate", str(profile.rate)),
        ("maxInstances", str(profile.max_instances)),
    ):
        assert info.attrib[f"{RTC}{key}"] == value, key
