"""Factors `cia402` of a bus file: from a drive's objects to angles and lengths."""

from __future__ import annotations

from math import tau
from pathlib import Path

import pytest

from rtgen import api
from rtgen.compiler.diagnostics import InputError

EDS = (
    Path(__file__).parents[2]
    / "golden/cases/LINT0022_factor_of_a_drive/input/drive.eds"
).read_text()
PAIR = """
[{0:X}]
ParameterName={1}
ObjectType=0x8
SubNumber=3

[{0:X}sub0]
ParameterName=Highest sub-index supported
ObjectType=0x7
DataType=0x0005
AccessType=const
DefaultValue=2

[{0:X}sub1]
ParameterName=Numerator
ObjectType=0x7
DataType=0x0007
AccessType=rw
DefaultValue=1

[{0:X}sub2]
ParameterName=Denominator
ObjectType=0x7
DataType=0x0007
AccessType=rw
DefaultValue=1
"""
UNIT = """
[60AA]
ParameterName=SI unit acceleration
ObjectType=0x7
DataType=0x0007
AccessType=rw
DefaultValue=0x00B45700
"""
BUS = """[bus]
bit_rate = 500
[device.drive]
eds = "drive.eds"
[device.drive.values]
{values}
[device.drive.factors]
"{object}" = "cia402"
[device.drive.units]
"{object}" = "{unit}"
[node.left]
device = "drive"
id = 1
"""
INCREMENTS, MM, DEGREE_10 = 0x00B50000, 0xFD010000, 0xFF410000
INCREMENTS_S, MM_S, RPM = 0x00B50300, 0xFD010300, 0x00B44700
M_S2 = 0x00015700


def factor(folder: Path, number: str, unit: str, **values: int) -> float:
    """Return the factor of an object; `values` are objects, `_` before a sub-index."""
    listed = {"6090": 0x6090, "6092": 0x6092, "60AA": 0x60AA}
    used = [n for n in listed if any(v.startswith(f"o{n}") for v in values)]
    units = EDS.index("[60A8]")
    eds = EDS[:units] + EDS[units:].replace("AccessType=ro", "AccessType=rw")
    text = eds.replace("[OptionalObjects]\nSupportedObjects=8\n", "@")
    assert "@" in text
    places = "".join(f"{9 + n}=0x{name}\n" for n, name in enumerate(used))
    text = text.replace("8=0x60A9\n", f"8=0x60A9\n{places}").replace(
        "@", f"[OptionalObjects]\nSupportedObjects={8 + len(used)}\n"
    )
    for name in used:
        text += UNIT if name == "60AA" else PAIR.format(listed[name], f"Ratio {name}")
    (folder / "drive.eds").write_text(text)
    bus = folder / "bus.toml"
    settings = (
        f'"{name[1:].replace("_", ":")}" = {value}' for name, value in values.items()
    )
    bus.write_text(BUS.format(values="\n".join(settings), object=number, unit=unit))
    [kind] = api.compile(bus).buses[0].kinds
    [(_, found)] = kind.factors
    return found


@pytest.mark.parametrize(
    ("number", "unit", "values", "expected"),
    [
        # 2000 increments for a turn of the motor, a gear of 14:1.
        ("6064", "rad", {"o60A8": INCREMENTS}, tau / 2000 / 14),
        ("606C", "rad/s", {"o60A8": INCREMENTS, "o60A9": RPM}, tau / 60 / 14),
        (
            "606C",
            "rad/s",
            {"o60A8": INCREMENTS, "o60A9": INCREMENTS_S},
            tau / 2000 / 14,
        ),
        (
            "606C",
            "deg/s",
            {"o60A8": DEGREE_10, "o60A9": INCREMENTS_S, "o6090_1": 512, "o6090_2": 1},
            360 / 512 / 14,
        ),
        ("6064", "deg", {"o60A8": DEGREE_10}, 0.1),
        ("6064", "m", {"o60A8": MM}, 1e-3),
        ("606C", "m/s", {"o60A8": MM, "o60A9": MM_S}, 1e-3),
        ("6083", "mm/s^2", {"o60A8": MM, "o60A9": MM_S, "o60AA": M_S2}, 1e3),
        ("6083", "mm/s^2", {"o60A8": MM, "o60A9": MM_S}, 1.0),
        # A wheel of 0.5 m around: 500 mm for a turn of the driving shaft.
        ("6064", "rad", {"o60A8": MM, "o6092_1": 500, "o6092_2": 1}, tau / 500),
        (
            "606C",
            "rpm",
            {"o60A8": MM, "o60A9": MM_S, "o6092_1": 1000, "o6092_2": 2},
            60 / 500,
        ),
        (
            "606C",
            "m/s",
            {"o60A8": MM, "o60A9": RPM, "o6092_1": 500, "o6092_2": 1},
            0.5 / 60,
        ),
    ],
)
def test_factors(
    tmp_path: Path, number: str, unit: str, values: dict[str, int], expected: float
) -> None:
    gear = {"o6091_1": 14, "o6091_2": 1}
    assert factor(tmp_path, number, unit, **gear, **values) == pytest.approx(expected)


@pytest.mark.parametrize(
    ("number", "unit", "values", "word"),
    [
        ("6064", "m", {"o60A8": INCREMENTS}, "an angle"),
        ("6064", "rad", {"o60A8": MM}, "a length"),
        ("606C", "m", {"o60A8": MM, "o60A9": MM_S}, "a length in time"),
        ("6064", "rad", {"o60A8": MM, "o6092_1": 0, "o6092_2": 1}, "6092h:1"),
        ("606C", "rad/s", {"o60A8": MM, "o60A9": 0x00B50000}, "00h is not known"),
    ],
)
def test_objects_that_do_not_determine_a_factor(
    tmp_path: Path, number: str, unit: str, values: dict[str, int], word: str
) -> None:
    with pytest.raises(InputError) as caught:
        factor(tmp_path, number, unit, **values)
    assert word in str(caught.value.diagnostics)
