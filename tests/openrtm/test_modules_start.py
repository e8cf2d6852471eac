"""Modules with the behaviours of the reference build, started and used as by an engineer."""

from __future__ import annotations

import shutil
import subprocess
import time
from pathlib import Path
from typing import Any

import middleware
import openrtm_peers as peers
import pytest
from conformance import component_of
from openrtm_lab import Lab, resolved
from patience import until

ROOT = Path(__file__).parents[2]
REASONS = {
    "Navigation": "",
    "OmniTo2WD": "",
    "PathFollower": "",
    "RefHardRh3": "",
    "Odometry": "a wheel is missing",
    "PositionInput": "all commands are carried out",
    "RefHardRh3Tecs": "",
    "SimulatedMotorBoard": "",
    "MotorBoardMarshaller": "",
    "OpaqueRpcCommunication": "",
    "RefHardRh3Canopen": "",
    "EposDriveProxy": "",
    "EposDriveDevice": "",
    "CanopenManager": "there is no network ''",
    "PathPlanning": "route_map",
    "VelocityAdapter": "",
}
"""Some modules of every kind; the log explains those that end in ERROR."""
IN_EVERY_RUN = {"Navigation", "PositionInput"}


@pytest.fixture(scope="session")
def complete(reference: Path) -> Path:
    """Return the reference build with its behaviours in place of the project's skeletons."""
    behaviours = reference.parent / "src" / "refnav"
    shutil.copytree(ROOT / "reference" / "refnav", behaviours, dirs_exist_ok=True)
    return reference


@pytest.mark.sampled(1)
@pytest.mark.parametrize(
    "name",
    [
        pytest.param(name, marks=() if name in IN_EVERY_RUN else pytest.mark.slow)
        for name in REASONS
    ],
)
def test_a_module_starts_runs_and_ends(
    name: str,
    rtm: Any,
    lab: Lab,
    complete: Path,
    naming_service: str,
    rtm_environment: dict[str, str],
) -> None:
    import RTC

    folder = complete / "openrtm" / name
    if not (folder / "stubs").is_dir():
        script = ["sh", "idlcompile.sh"]
        subprocess.run(script, cwd=folder, env=rtm_environment, check=True)
    peers.load_stubs(folder / "stubs")
    options = {
        "corba.nameservers": naming_service,
        "naming.formats": "start/%n.rtc",
        "logger.file_name": "./rtc.log",
        "exec_cxt.transition_timeout": "20",
    }
    command = [f"{name}.py", "-f", "rtc.conf"]
    with middleware.launched(command, options, rtm_environment, folder) as process:
        component = resolved(rtm, naming_service, f"start/{name}0.rtc", process)
        writers = [
            feeding(rtm, lab, component, f"{name}0.{port}", in_port.type)
            for port, in_port in component_of(name).in_ports.items()
        ]
        activated = rtm.activate(component)
        # An error in the first cycle may come before the context reads the state.
        assert activated == RTC.RTC_OK or REASONS[name]
        for writer in writers:
            assert writer.write()
        if REASONS[name]:
            until(lambda: rtm.is_in_error(component))
            assert REASONS[name] in (folder / "rtc.log").read_text()
            assert rtm.reset(component) == RTC.RTC_OK
        else:
            time.sleep(3.0 / rtm.get_current_rate(component, 0))
            assert rtm.is_in_active(component), (folder / "rtc.log").read_text()
            assert rtm.deactivate(component) == RTC.RTC_OK
        assert rtm.is_in_inactive(component)
        component.exit()
        assert process.wait(20) == 0, (folder / "manager.out").read_text()


def feeding(rtm: Any, lab: Lab, component: Any, port: str, type_: Any) -> Any:
    """Return an OutPort with an initial value of the type that is connected to an InPort."""
    import RTC

    out = lab.out_port(peers.wire(type_()))
    target = rtm.get_port_by_name(component, port)
    asked = rtm.Properties()
    assert rtm.connect("feed", asked, out.getPortRef(), target) == RTC.RTC_OK, port
    return out
