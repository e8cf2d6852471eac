"""Verified facts about managers of OpenRTM-aist-Python 2.1 in processes of their own."""

from __future__ import annotations

import os
import subprocess
import sys
from pathlib import Path
from typing import Any

import middleware
import pytest
from openrtm_lab import Lab, resolved
from patience import until

MODULE = Path(__file__).parent / "modules" / "Doubler.py"


@pytest.fixture
def options(naming_service: str, request: pytest.FixtureRequest) -> dict[str, str]:
    """Return options of all managers in these tests; names are specific to the test."""
    return {
        "corba.nameservers": naming_service,
        "corba.endpoints": "127.0.0.1:",
        "logger.enable": "NO",
        "exec_cxt.transition_timeout": "20",
        "naming.formats": f"{request.node.name}.test/%n.rtc",
    }


def long(value: int) -> Any:
    import RTC

    return RTC.TimedLong(RTC.Time(0, 0), value)


def test_a_module_runs_is_used_and_ends_with_its_component(
    rtm: Any,
    lab: Lab,
    options: dict[str, str],
    naming_service: str,
    rtm_environment: dict[str, str],
    tmp_path: Path,
    request: pytest.FixtureRequest,
) -> None:
    import RTC
    from omniORB import CORBA

    with middleware.launched(
        [str(MODULE)], options, rtm_environment, tmp_path
    ) as process:
        name = f"{request.node.name}.test/Doubler0.rtc"
        component = resolved(rtm, naming_service, name)
        assert rtm.get_port_names(component) == ["Doubler0.in", "Doubler0.out"]
        assert rtm.get_current_rate(component, 0) == 1000.0
        out, inp = lab.out_port(long(0)), lab.in_port(long(0))
        push = rtm.Properties()
        inlet = rtm.get_port_by_name(component, "Doubler0.in")
        outlet = rtm.get_port_by_name(component, "Doubler0.out")
        assert rtm.connect("in", push, out.getPortRef(), inlet) == RTC.RTC_OK
        assert rtm.connect("out", push, outlet, inp.getPortRef()) == RTC.RTC_OK
        assert rtm.set_configuration(component, "default", "factor", "3")
        assert rtm.activate(component) == RTC.RTC_OK
        assert rtm.is_in_active(component)
        assert out.write(long(4))
        until(inp.isNew)
        assert inp.read().data == 12
        assert rtm.deactivate(component) == RTC.RTC_OK
        component.exit()
        assert process.wait(20) == 0
        assert out.write(long(4)) is False
        with pytest.raises(CORBA.Exception):
            rtm.CorbaNaming(rtm.Manager.instance().getORB(), naming_service).resolve(
                name
            )


def test_configuration_files_of_manager_type_and_instance(
    rtm: Any,
    options: dict[str, str],
    naming_service: str,
    rtm_environment: dict[str, str],
    tmp_path: Path,
    request: pytest.FixtureRequest,
) -> None:
    """The rate of a component's file counts, the instance wins over the type, `-o` over all."""
    (tmp_path / "Doubler.conf").write_text(
        "# of the type\n"
        "exec_cxt.periodic.rate: 50\n"
        "conf.default.factor: \\\n"
        "  5\n"
        "conf.__widget__.factor: spin\n"
    )
    (tmp_path / "rtc.conf").write_text(
        "Test.Doubler.config_file: Doubler.conf\n"
        "Test.Doubler1.conf.default.factor: 6\n"
        "exec_cxt.periodic.rate: 20\n"
        "manager.modules.load_path: elsewhere\n"
        "manager.components.precreate: Doubler\n"
        "manager.components.preconnect: Doubler0.out?port=Doubler1.in"
        "&dataflow_type=push&interface_type=corba_cdr&subscription_type=new\n"
        "manager.components.preactivation: Doubler1\n"
    )
    options["manager.modules.load_path"] = str(MODULE.parent)
    with middleware.launched([str(MODULE)], options, rtm_environment, tmp_path):
        first, second = (
            resolved(rtm, naming_service, f"{request.node.name}.test/Doubler{n}.rtc")
            for n in range(2)
        )
        until(lambda: rtm.is_in_active(second))
        assert rtm.is_in_inactive(first)
        assert rtm.get_parameter_by_key(first, "default", "factor") == "5"
        assert rtm.get_parameter_by_key(first, "__widget__", "factor") == "spin"
        assert rtm.get_parameter_by_key(second, "default", "factor") == "6"
        assert rtm.get_current_rate(first, 0) == 50.0
        outlet = rtm.get_port_by_name(first, "Doubler0.out")
        (connection,) = outlet.get_connector_profiles()
        properties = {each.name: each.value.value() for each in connection.properties}
        assert properties["dataport.subscription_type"] == "new"


def script(
    text: str, environment: dict[str, str], folder: Path, *arguments: str
) -> str:
    """Return the output of a program, including errors."""
    done = subprocess.run(
        [sys.executable, "-c", text, *arguments],
        env=environment,
        cwd=folder,
        capture_output=True,
        text=True,
        check=False,
    )
    return done.stdout + done.stderr


@pytest.mark.usefixtures("openrtm")
def test_an_unknown_option_makes_a_manager_ignore_all(
    rtm_environment: dict[str, str], tmp_path: Path
) -> None:
    text = """
import sys, OpenRTM_aist
manager = OpenRTM_aist.Manager.init(["manager", *sys.argv[1:], "-o", "lab.x:1"])
print("<%s>" % manager.getConfig().getProperty("lab.x"))
manager.shutdown()
"""
    (tmp_path / "rtc.conf").write_text(
        "corba.endpoints: 127.0.0.1:\nnaming.enable: NO\nlogger.enable: NO\n"
    )
    assert "<1>" in script(text, rtm_environment, tmp_path)
    own = "--instance_name=me"
    assert "<>" in script(text, rtm_environment, tmp_path, own)


@pytest.mark.usefixtures("openrtm")
@pytest.mark.parametrize(
    ("arguments", "refused"), [("", True), ("-ORBnativeCharCodeSet UTF-8", False)]
)
def test_texts_are_latin_unless_the_orb_is_configured(
    rtm_environment: dict[str, str], tmp_path: Path, arguments: str, refused: bool
) -> None:
    text = """
import OpenRTM_aist, RTC
manager = OpenRTM_aist.Manager.init(["manager"])
manager.activateManager()
manager.runManager(True)
inp = OpenRTM_aist.InPort("i", RTC.TimedString(RTC.Time(0, 0), ""))
out = OpenRTM_aist.OutPort("o", RTC.TimedString(RTC.Time(0, 0), ""))
names = ["implementation_id", "Echo", "type_name", "Echo", "category", "lab", ""]
profile = OpenRTM_aist.Properties(defaults_str=names)
manager.registerFactory(profile, OpenRTM_aist.DataFlowComponentBase, OpenRTM_aist.Delete)
echo = manager.createComponent("Echo")
echo.addInPort("i", inp)
echo.addOutPort("o", out)
code = OpenRTM_aist.connect(
    "c", OpenRTM_aist.Properties(), out.getPortRef(), inp.getPortRef()
)
assert code == RTC.RTC_OK, code
text = RTC.TimedString(RTC.Time(0, 0), "\\u6f22")
print(out.write(text), inp.read().data == text.data)
manager.shutdown()
"""
    (tmp_path / "rtc.conf").write_text(
        f"corba.endpoints: 127.0.0.1:\nnaming.enable: NO\nlogger.enable: NO\n"
        f"corba.args: {arguments}\n"
    )
    answer = script(text, rtm_environment, tmp_path)
    assert answer.split() == [str(not refused)] * 2


@pytest.fixture
def reopening(tmp_path: Path) -> Path:
    """Return a folder with stubs of an IDL file that adds to the module RTC and to no module."""
    file = tmp_path / "reopening.idl"
    file.write_text(
        "module RTC { struct Added { long number; }; };\ninterface Unscoped { void go(); };\n"
    )
    folder = tmp_path / "stubs"
    folder.mkdir()
    middleware.compile_idl(folder, [file])
    return folder


def first_of_all(environment: dict[str, str], folder: Path) -> dict[str, str]:
    path = [str(folder), environment.get("PYTHONPATH", "")]
    return {**environment, "PYTHONPATH": os.pathsep.join(path)}


@pytest.mark.usefixtures("openrtm")
def test_stubs_that_reopen_rtc_must_not_be_found_first(
    reopening: Path, rtm_environment: dict[str, str], tmp_path: Path
) -> None:
    before = first_of_all(rtm_environment, reopening)
    assert "AttributeError" in script("import OpenRTM_aist", before, tmp_path)
    after = f"""
import sys, OpenRTM_aist, RTC
sys.path.append({str(reopening)!r})
import reopening_idl
print(RTC.Added(5).number, RTC.TimedLong)
"""
    assert script(after, rtm_environment, tmp_path).startswith("5 ")


@pytest.mark.sampled(1)
@pytest.mark.usefixtures("openrtm")
def test_unscoped_stubs_must_be_found_first(
    rtm_environment: dict[str, str], tmp_path: Path
) -> None:
    file = tmp_path / "alone.idl"
    file.write_text("interface Alone { void go(); };\n")
    folder = tmp_path / "stubs"
    folder.mkdir()
    middleware.compile_idl(folder, [file])
    text = "import OpenRTM_aist, _GlobalIDL; print(_GlobalIDL.Alone)"
    behind = f"import sys; sys.path.append({str(folder)!r}); {text}"
    assert "AttributeError" in script(behind, rtm_environment, tmp_path)
    first = script(text, first_of_all(rtm_environment, folder), tmp_path)
    assert "Alone" in first
    assert "Error" not in first


@pytest.mark.usefixtures("openrtm")
def test_the_root_logger_receives_what_a_manager_logs(
    rtm_environment: dict[str, str], tmp_path: Path
) -> None:
    text = """
import logging, OpenRTM_aist
logging.basicConfig(format="root: %(message)s")
manager = OpenRTM_aist.Manager.init(["manager"])
manager.getLogbuf("lab").RTC_WARN("%s", "low battery")
manager.shutdown()
"""
    (tmp_path / "rtc.conf").write_text(
        "corba.endpoints: 127.0.0.1:\nnaming.enable: NO\nlogger.file_name: ./lab.log\n"
    )
    assert "root: low battery" in script(text, rtm_environment, tmp_path)
    assert "low battery" in (tmp_path / "lab.log").read_text()
