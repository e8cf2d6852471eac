"""`rtgen new ros2-package`: packages for colcon, with interfaces, programs and launch files."""

from __future__ import annotations

import ast
import os
import re
from pathlib import Path
from xml.etree import ElementTree

import pytest

from rtgen.cli import run
from rtgen.compiler.diagnostics import InputError
from rtgen.tools.scaffold.names import ros_package_name

IDL = """
#include "geometry_msgs/msg/Twist.idl"
#include "lab_msgs/msg/Load.idl"
module Lab {
    struct Place { double minAngle; lab_msgs::msg::Load load; };
    union Either switch (boolean) { case TRUE: long a; };
    struct Odd { Either part; };
    interface Arm { double move(in Place where); };
};
@rtc(category="Demo", vendor="me", rate=20.0)
component Drive {
    consumes geometry_msgs::msg::Twist command;
    publishes lab_msgs::msg::Load load;
};
"""
BEHAVIOUR = '''"""Publishes a load."""

from rover.components.drive import DriveBase
from rover.lab_msgs.msg import Load
from rtgen.runtime import RTC_OK, ReturnCode_t


class Drive(DriveBase):
    """Publishes a load."""

    def on_execute(self, ec_id: int) -> ReturnCode_t:
        """In each cycle."""
        self.load.write(Load(mass=2.5))
        return RTC_OK
'''
SYSTEM = """<?xml version="1.0" encoding="UTF-8"?>
<rts:RtsProfile rts:id="RTSystem:me:two_drives:1.0.0" rts:version="0.2"
    xmlns:rts="http://www.openrtp.org/namespaces/rts">
  {components}
</rts:RtsProfile>
"""
COMPONENT = """<rts:Components rts:id="RTC:me:Demo:Drive:1.0.0" rts:instanceName="{0}"
      rts:pathUri="localhost/{0}.rtc" rts:compositeType="None" rts:isRequired="true"/>"""
TOML = """[sources]
paths = ["idl", "lab_msgs", "systems"]
[output]
package = "rover"
skeletons = "src/rover_parts"
[ros2]
namespace = "/lab"
{more}
[ros2.topics]
"Left0.load" = "load"
"""


def project(folder: Path, more: str = "") -> Path:
    """Write a project with a system of two components and its generated files."""
    files = {
        "idl/drive.idl": IDL,
        "lab_msgs/msg/Load.msg": "# A load.\n\nuint8 FULL=1\nfloat64 mass 1.5  # [kg]\n",
        "src/rover_parts/drive.py": BEHAVIOUR,
        "src/rover_parts/__init__.py": "",
        "systems/two_drives.xml": SYSTEM.format(
            components="\n  ".join(
                COMPONENT.format(name) for name in ("Left0", "Right0")
            )
        ),
        "rtgen.toml": TOML.format(more=more),
    }
    for name, text in files.items():
        path = folder / name
        path.parent.mkdir(parents=True, exist_ok=True)
        path.write_text(text, encoding="utf-8")
    return folder


@pytest.fixture
def rover(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    folder = project(tmp_path / "rover")
    monkeypatch.chdir(folder)
    assert run(["generate", "-q"]) == 0
    return folder


def texts(manifest: Path, tag: str) -> list[str | None]:
    return [each.text for each in ElementTree.parse(manifest).getroot().iter(tag)]


def below(folder: Path) -> set[str]:
    """Return the files and links below a folder, not those that links lead to."""
    return {
        (Path(place) / name).relative_to(folder).as_posix()
        for place, folders, names in os.walk(folder)
        for name in (*names, *folders)
        if not (Path(place) / name).is_dir() or (Path(place) / name).is_symlink()
    }


def test_files(rover: Path, capsys: pytest.CaptureFixture[str]) -> None:
    (rover / "pyproject.toml").write_text(
        '[project]\nname = "rover"\nversion = "1.2rc1"\nlicense = {text = "MIT"}\n'
        'authors = [{name = "<Ann>", email = "ann@lab.example"}, {name = "Bo"}]\n'
    )
    assert run(["new", "ros2-package", "rover_ros"]) == 0
    assert "ROS0120" in capsys.readouterr().err
    assert below(rover / "ros2") == {
        *("lab/CMakeLists.txt", "lab/package.xml"),
        *("lab/msg/Place.msg", "lab/srv/ArmMove.srv"),
        *("lab_msgs/CMakeLists.txt", "lab_msgs/package.xml", "lab_msgs/msg/Load.msg"),
        *("rover_ros/package.xml", "rover_ros/setup.py", "rover_ros/setup.cfg"),
        *("rover_ros/resource/rover_ros", "rover_ros/launch/two_drives.launch.py"),
        *("rover_ros/rover_ros/__init__.py", "rover_ros/rover_ros/systems.py"),
        *(
            f"rover_ros/project/{part}"
            for part in ("generated", "idl", "lab_msgs", "rtgen.toml", "src", "systems")
        ),
    }
    linked = rover / "ros2/rover_ros/project/systems/two_drives.xml"
    assert linked.samefile(rover / "systems/two_drives.xml")
    manifest = rover / "ros2/lab/package.xml"
    assert texts(manifest, "version") == ["1.2.0"]
    assert texts(manifest, "maintainer") == ["<Ann>"]
    assert texts(manifest, "license") == ["MIT"]
    assert texts(manifest, "depend") == ["lab_msgs", "service_msgs"]
    needed = texts(rover / "ros2/rover_ros/package.xml", "exec_depend")
    assert {"lab", "lab_msgs", "geometry_msgs", "rclpy", "launch_ros"} <= {*needed}
    for path in (rover / "ros2/rover_ros").glob("*/*.py"):
        ast.parse(path.read_text(encoding="utf-8"))
    launch = (rover / "ros2/rover_ros/launch/two_drives.launch.py").read_text()
    assert re.findall('"(Left0|Right0)"', launch) == ["Left0", "Right0"]
    assert 'NAMESPACE = "/lab"' in launch
    assert run(["check", "-q"]) == 0
    # A second one keeps the packages of interfaces.
    (rover / "ros2/lab/package.xml").write_text("mine")
    assert run(["new", "ros2-package", "rover_ros"]) == 2
    assert run(["new", "ros2-package", "other"]) == 0
    assert "left as they are: lab_msgs, lab" in capsys.readouterr().err
    assert (rover / "ros2/lab/package.xml").read_text() == "mine"


def test_without_interfaces_and_managed_nodes(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Only the Python package; the folder may be elsewhere; facts are in rtgen.toml."""
    more = 'managed_nodes = false\nmaintainer = "Ann B <a@b.example>"\nlicense = "BSD-3-Clause"'
    folder = project(tmp_path / "rover", more)
    idl = (
        '#include "BasicDataType.idl"\n@rtc(category="Demo", vendor="me", rate=20.0)\n'
        "component Drive { publishes RTC::TimedDouble load; };\n"
    )
    (folder / "idl/drive.idl").write_text(idl)
    (folder / "lab_msgs/msg/Load.msg").unlink()
    (folder / "lab_msgs/package.xml").write_text("")
    monkeypatch.chdir(folder)
    source = tmp_path / "ws/src"
    source.mkdir(parents=True)
    arguments = ["--folder", str(source), "--system", "systems/two_drives.xml"]
    assert run(["new", "ros2-package", "rover_ros", *arguments]) == 0
    assert [each.name for each in source.iterdir()] == ["rover_ros"]
    manifest = source / "rover_ros/package.xml"
    assert texts(manifest, "maintainer") == ["Ann B"]
    assert texts(manifest, "license") == ["BSD-3-Clause"]
    launch = (source / "rover_ros/launch/two_drives.launch.py").read_text()
    assert "Lifecycle" not in launch
    assert "--inactive" not in launch
    assert (source / "rover_ros/project/rtgen.toml").samefile("rtgen.toml")


def test_interfaces_of_others(rover: Path) -> None:
    """A package that colcon builds already is needed, not written; generated ones are linked."""
    (rover / "lab_msgs/package.xml").write_text("<package/>")
    text = (rover / "rtgen.toml").read_text()
    text = text.replace("[ros2]", "[ros2]\ninterfaces = true")
    (rover / "rtgen.toml").write_text(text)
    assert run(["new", "ros2-package", "rover_ros"]) == 0
    assert below(rover / "ros2/lab") == {"CMakeLists.txt", "package.xml", "msg", "srv"}
    place = rover / "ros2/lab/msg/Place.msg"
    assert place.samefile(rover / "generated/ros2/lab/msg/Place.msg")
    assert not (rover / "ros2/lab_msgs").exists()
    assert "lab_msgs" in texts(rover / "ros2/lab/package.xml", "depend")


def test_the_system_of_a_run(rover: Path) -> None:
    text = (rover / "rtgen.toml").read_text()
    text = text.replace(', "systems"', "") + '[run]\nsystem = "drives"\n'
    (rover / "rtgen.toml").write_text(text)
    assert run(["new", "ros2-package", "rover_ros"]) == 2
    (rover / "systems").rename(rover / "drives")
    (rover / "drives/two_drives.xml").rename(rover / "drives/system.xml")
    assert run(["new", "ros2-package", "rover_ros"]) == 0
    assert (rover / "ros2/rover_ros/launch/drives.launch.py").is_file()
    assert (rover / "ros2/rover_ros/project/drives/system.xml").is_file()


def test_components_that_stay_inactive(
    rover: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    del rover
    for options, states in (([], {"ACTIVE"}), (["--inactive"], {"INACTIVE"})):
        assert run(["run", "systems/two_drives.xml", "--until", "0.1", *options]) == 0
        rows = re.findall(r"^(?:Left0|Right0) +(\w+)", capsys.readouterr().out, re.M)
        assert len(rows) == 2
        assert {*rows} == states


def test_nothing_half_written(rover: Path) -> None:
    (rover / "idl/drive.idl").write_text("struct {")
    assert run(["new", "ros2-package", "rover_ros"]) == 2
    assert not (rover / "ros2").exists()
    (rover / "pyproject.toml").write_text("[project\n")
    (rover / "idl/drive.idl").write_text(IDL)
    assert run(["new", "ros2-package", "rover_ros"]) == 3
    assert not (rover / "ros2").exists()


@pytest.mark.parametrize(
    ("name", "hint"),
    [
        ("Rover", "did you mean rover?"),
        ("my-robot", "did you mean my_robot?"),
        ("my__robot", "did you mean my_robot?"),
        ("2wheels", "did you mean wheels?"),
        ("robot_", "did you mean robot?"),
        ("ロボット", None),
        ("x", None),
        ("", None),
        ("class", None),
        ("json", None),
        ("lab_msgs", "for example lab_msgs_systems"),
        ("a" * 65, None),
    ],
)
def test_names(name: str, hint: str | None) -> None:
    with pytest.raises(InputError) as caught:
        ros_package_name(name, {"lab_msgs"})
    [finding] = caught.value.diagnostics
    assert finding.code == "NEW0001"
    assert hint is None or finding.hint == hint
    ros_package_name("rover_2", {"lab_msgs"})


def test_boards_and_devices(rover: Path) -> None:
    """The services of boards are a package; types of descriptions of devices are none."""
    assert run(["new", "board", "Lamp"]) == 0
    assert run(["new", "device", "Motor"]) == 0
    assert run(["new", "ros2-package", "rover_ros"]) == 0
    packages = {each.name for each in (rover / "ros2").iterdir()}
    boards = {each.name for each in (rover / "generated/ros2").iterdir()}
    assert boards
    assert packages == {"lab", "lab_msgs", "rover_ros", *boards}
    for board in boards:
        assert below(rover / "ros2" / board) >= {"CMakeLists.txt", "package.xml", "srv"}
        assert "service_msgs" in texts(rover / "ros2" / board / "package.xml", "depend")


LAMP = """
signature sLamp { uint8_t level( void ); };
celltype tLamp { entry sLamp eLamp; };
[active] celltype tSwitch { call sLamp cLamp; };
cell tLamp Lamp { };
cell tSwitch Switch {
    [through( RTCPlugin, "" )]
    cLamp = Lamp.eLamp;
};
"""


def test_boards_without_a_system(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Their package runs them alone; a launch file has the RTCs that a run adds to its system."""
    monkeypatch.chdir(tmp_path)
    (tmp_path / "lamp.cdl").write_text(LAMP)
    project = '[sources]\npaths = ["lamp.cdl"]\n[output]\npackage = "lit"\n[ros2]\n'
    (tmp_path / "rtgen.toml").write_text(project)
    assert run(["new", "ros2-package", "lit_ros"]) == 0
    package = tmp_path / "ros2/lit_ros"
    assert (tmp_path / "ros2/lit_lamp/srv/LampLevel.srv").is_file()
    assert (package / "project/lamp.cdl").is_file()
    assert '_run("rtgen.toml")' in (package / "lit_ros/systems.py").read_text()
    added = '    "OpaqueRpcCommunication0",\n    "LampMarshaller0",\n]'
    assert added in (package / "launch/boards.launch.py").read_text()
    (tmp_path / "empty.xml").write_text(SYSTEM.format(components=""))
    assert run(["new", "ros2-package", "more_ros", "--system", "empty.xml"]) == 0
    launch = tmp_path / "ros2/more_ros/launch/empty.launch.py"
    assert added in launch.read_text()
    (tmp_path / "rtgen.toml").write_text(project + "boards = false\n")
    assert run(["new", "ros2-package", "no_ros"]) == 2
