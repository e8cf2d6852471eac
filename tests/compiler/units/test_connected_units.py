"""Units of two connected ports: what `rtgen inspect` reports, and the adapter of its hint."""

from __future__ import annotations

import re
from pathlib import Path

import pytest

from rtgen.cli import run

IDL = """#include "BasicDataType.idl"
#include "ExtendedDataTypes.idl"
module Units {{
    struct Wheels {{ @unit("mm/s") double left; double right; ///< [mm/s]
    }};
    struct Partly {{ double value; double at; ///< [ms]
    }};
    struct Gas {{ double pressure; ///< Above that of the air [mm[Hg]].
    }};
    struct Odd {{ double value; ///< [0..1]
    }};
    typedef double Three[3];
    struct Grid {{ float cells[2][3]; }};
    struct Table {{ sequence<Three> rows; }};
    struct Count {{ long number; }};
    struct Counts {{ long id; long speed; ///< [deg/s]
    }};
    struct Maybe {{ @optional double value; }};
}};
@rtc(category="Units", vendor="me")
component Source {{ @unit("{sent}") publishes {type} given; }};
@rtc(category="Units", vendor="me")
component Sink {{ @unit("{wanted}") consumes {type} taken; }};
"""
SYSTEM = """<?xml version="1.0" encoding="UTF-8"?>
<rts:RtsProfile rts:id="RTSystem:me:units:1.0.0" rts:version="0.2"
    xmlns:rts="http://www.openrtp.org/namespaces/rts">
{components}{connectors}</rts:RtsProfile>
"""
CONNECTOR = """  <rts:DataPortConnectors rts:name="{source} {target}">
    <rts:sourceDataPort rts:instanceName="{source}" rts:portName="{source}.{out}"/>
    <rts:targetDataPort rts:instanceName="{target}" rts:portName="{target}.{into}"/>
  </rts:DataPortConnectors>
"""
DOUBLE, POSE = "RTC::TimedDouble", "RTC::TimedPose2D"


def system(*connections: tuple[str, str, str, str]) -> str:
    """Return a system of components with the instance names of their types."""
    vendors = {"Conv": "RTC:rtgen:Adapters:Conv:1.0.0"}
    names = dict.fromkeys(n for c in connections for n in (c[0], c[2]))
    return SYSTEM.format(
        components="".join(
            f'  <rts:Components rts:id="{vendors.get(n, f"RTC:me:Units:{n}:1.0.0")}" '
            f'rts:instanceName="{n}"/>\n'
            for n in names
        ),
        connectors="".join(
            CONNECTOR.format(source=s, out=out, target=t, into=into)
            for s, out, t, into in connections
        ),
    )


@pytest.fixture
def folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    monkeypatch.chdir(tmp_path)
    (tmp_path / "s.xml").write_text(system(("Source", "given", "Sink", "taken")))
    return tmp_path


@pytest.mark.parametrize(
    ("sent", "wanted", "code"),
    [
        ("m s", "ms", "error[RTC0593]"),
        ("m rad", "mrad", "error[RTC0593]"),
        ("m/s", "m  /  s", ""),
        ("N m", "Nm", ""),
        ("Cel", "degC", ""),
        ("Cel", "[degF]", "warning[RTC0595]"),
        ("[in_i]/s", "m/s", "warning[RTC0595]"),
        ("{count}", "rad", "error[RTC0593]"),
        (" ", "m", 'write @unit("m") at the port'),
    ],
)
def test_units_of_two_ports(
    folder: Path, capfd: pytest.CaptureFixture[str], sent: str, wanted: str, code: str
) -> None:
    (folder / "a.idl").write_text(IDL.format(type=DOUBLE, sent=sent, wanted=wanted))
    assert run(["inspect", "s.xml", "a.idl"]) == (2 if "error" in code else 0)
    said = capfd.readouterr().err
    assert code in said if code else said == ""


SILENT = "does not say its unit"


@pytest.mark.sampled(5)
@pytest.mark.parametrize(
    ("type_", "sent", "wanted", "code"),
    [
        (POSE, "", "mm, rad", "warning[RTC0595]: Source.given gives m, rad"),
        (POSE, "m, deg", "", "warning[RTC0595]"),
        (POSE, "", "s, rad", "error[RTC0593]"),
        (POSE, "", "m, rad", ""),
        (POSE, "", "", ""),
        (POSE, "", "mm", SILENT),
        (DOUBLE, "", "mm", SILENT),
        (POSE, "", "N*m", "error[RTC0593]: Source.given gives m, rad"),
        (POSE, "m, rad", "N*m", "error[RTC0593]"),
        ("Units::Partly", "", "s", SILENT),
        ("Units::Partly", "", "N*m", SILENT),
        ("Units::Partly", "", "ms", ""),
        ("Units::Counts", "", "N*m", "error[RTC0593]: Source.given gives deg/s"),
        ("Units::Counts", "", "deg/s", ""),
        ("Units::Odd", "", "s", SILENT),
        ("Units::Gas", "", "mmHg", ""),
    ],
)
def test_a_port_without_a_unit_has_those_of_its_type(
    folder: Path,
    capfd: pytest.CaptureFixture[str],
    type_: str,
    sent: str,
    wanted: str,
    code: str,
) -> None:
    text = IDL.format(type=type_, sent=sent, wanted=wanted).replace(' @unit("")', "")
    (folder / "a.idl").write_text(text)
    assert run(["inspect", "s.xml", "a.idl"]) == (2 if "error" in code else 0)
    said = capfd.readouterr().err
    assert code in said if code else said == ""


@pytest.mark.sampled(2)
@pytest.mark.parametrize(
    ("type_", "sent", "wanted", "members"),
    [
        (DOUBLE, "km/h", "m/s", ["data"]),
        (POSE, "m, rad", "m, deg", ["data.heading"]),
        (POSE, "mm, rad", "m, rad", ["data.position.x", "data.position.y"]),
        ("RTC::TimedVelocity2D", "m/s, deg/s", "m/s, rad/s", ["data.va"]),
        ("Units::Wheels", "m/s", "mm/s", ["left", "right"]),
        ("Units::Grid", "m", "mm", ["cells"]),
        ("Units::Table", "m", "mm", ["rows"]),
    ],
)
def test_the_adapter_of_the_hint_removes_the_finding(
    folder: Path,
    capfd: pytest.CaptureFixture[str],
    type_: str,
    sent: str,
    wanted: str,
    members: list[str],
) -> None:
    (folder / "a.idl").write_text(IDL.format(type=type_, sent=sent, wanted=wanted))
    assert run(["inspect", "s.xml", "a.idl"]) == 0
    hint = capfd.readouterr().err
    found = re.search(r"with (from = .*), (to = .*), (units = {.*})", hint)
    assert found is not None, hint
    assert re.findall(r'"([\w.]+)" = ', found[3]) == members
    (folder / "rtgen.toml").write_text(
        "\n".join(['[sources]\npaths = ["."]\n[adapter.Conv]', *found.groups(), ""])
    )
    (folder / "s.xml").write_text(
        system(
            ("Source", "given", "Conv", "input"), ("Conv", "output", "Sink", "taken")
        )
    )
    assert run(["inspect", "s.xml"]) == 0
    assert capfd.readouterr().err == ""
    assert run(["generate", "-q", "--no-cache"]) == 0
    made = (folder / "generated/robots/adapters/conv.py").read_text()
    assert len(re.findall(r"\d\.\d+|\d+e-?\d+", made)) >= len(members)


@pytest.mark.parametrize("type_", ["Units::Count", "Units::Maybe"])
def test_no_adapter_is_suggested_that_could_not_convert(
    folder: Path, capfd: pytest.CaptureFixture[str], type_: str
) -> None:
    (folder / "a.idl").write_text(IDL.format(type=type_, sent="m", wanted="mm"))
    assert run(["inspect", "s.xml", "a.idl"]) == 0
    said = capfd.readouterr().err
    assert "warning[RTC0595]" in said
    assert "rtgen.toml" not in said
    assert "convert in a component" in said
