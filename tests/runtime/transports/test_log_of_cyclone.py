"""What Cyclone DDS's C library logs is in the log of the runtime, not raw on the terminal."""

from __future__ import annotations

from pathlib import Path

import media
import pytest

pytest.importorskip("cyclonedds", reason="cyclonedds is not installed")

DEPRECATED = """<CycloneDDS><Domain><General>
<NetworkInterfaceAddress>127.0.0.1</NetworkInterfaceAddress>
<AllowMulticast>false</AllowMulticast></General></Domain></CycloneDDS>"""
UNKNOWN = (
    "<CycloneDDS><Domain><General><Nothing>1</Nothing></General></Domain></CycloneDDS>"
)


def test_warnings_of_a_domain_that_opens(
    tmp_path: Path,
    capfd: pytest.CaptureFixture[str],
    caplog: pytest.LogCaptureFixture,
) -> None:
    from rtgen.runtime.dds.medium import DdsMedium

    config = tmp_path / "cyclone.xml"
    config.write_text(DEPRECATED)
    DdsMedium("log", domain=media.own_domain() + 20, config=config).close()
    assert capfd.readouterr().err == ""
    [text] = [r.getMessage() for r in caplog.records if "deprecated" in r.getMessage()]
    assert text.startswith("Cyclone DDS: ")


def test_the_reason_of_a_domain_that_does_not_open(
    tmp_path: Path, capfd: pytest.CaptureFixture[str]
) -> None:
    from rtgen.runtime.dds.medium import DdsMedium
    from rtgen.runtime.distribution.medium import MediumError

    config = tmp_path / "cyclone.xml"
    config.write_text(UNKNOWN)
    with pytest.raises(MediumError, match="Nothing: unknown element"):
        DdsMedium("log", domain=media.own_domain() + 21, config=config)
    assert capfd.readouterr().err == ""
