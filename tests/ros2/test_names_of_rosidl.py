"""The words of names, compared with those of rosidl's file names."""

from __future__ import annotations

import json
import random
import re
from pathlib import Path

import pytest
from ros2_peers import DISTRIBUTIONS, installation
from seeds import cases, seed

from rtgen.compiler.typemap.python.names import snake_case

pytestmark = [pytest.mark.peer, pytest.mark.random]

SCRIPT = """
import json, sys
from rosidl_pycommon import convert_camel_case_to_lower_case_underscore as convert
print(json.dumps([convert(name) for name in json.load(sys.stdin)]))
"""
OWN_WORDS = re.compile(r"CANopen|CiA|[A-Z]{2,}s")
"""What rtgen takes for one word."""


@pytest.mark.parametrize("distribution", DISTRIBUTIONS)
def test_names_of_types(distribution: str, tmp_path: Path) -> None:
    """All that are installed, and drawn ones."""
    made = installation(distribution)
    files = made.share.glob("*/*/*.idl")
    names = sorted({file.stem for file in files})
    assert len(names) > 100
    draw = random.Random(seed())
    letters = "ABCabcdS0129"
    drawn = [
        "T" + "".join(draw.choices(letters, k=draw.randint(0, 9))) for _ in cases(5000)
    ]
    names += [name for name in drawn if not OWN_WORDS.search(name)]
    script = tmp_path / "convert.py"
    script.write_text(SCRIPT)
    found = json.loads(made.output(script, text=json.dumps(names)))
    assert [snake_case(name) for name in names] == found
