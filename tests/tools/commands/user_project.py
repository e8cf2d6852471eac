"""The project of two components in docs/systems.md, and ways to break it."""

from __future__ import annotations

import re
import subprocess
import sys
import tempfile
from collections.abc import Mapping
from dataclasses import dataclass
from functools import cache
from pathlib import Path

DOCS = Path(__file__).parents[3] / "docs"
CONTROLLER = "src/heating/controller.py"
PATIENT = (
    "import sys; from rtgen.runtime.system import watchdog; watchdog.PATIENCE = 0.4;"
    "from rtgen.cli import run; sys.exit(run(sys.argv[1:]))"
)
"""The command line, with shorter time-outs for code that does not return."""


@dataclass(frozen=True)
class Break:
    """A way to break the controller; `page` is the first line that rtgen prints."""

    name: str
    old: str
    new: str
    code: int
    line: int
    page: str


TEN_WAYS = (
    Break("a colon", "if measured is not None:", "if measured is not None", 2, 16,
        "heating.controller:Controller, the factory of Controller, cannot be imported: "
        "SyntaxError: expected ':' (controller.py, line 16)"),
    Break("an import", "from warmth.heating", "from warmt.heating", 2, 7,
        "heating.controller:Controller, the factory of Controller, cannot be imported: "
        "ModuleNotFoundError: No module named 'warmt'"),
    Break("the class", "class Controller(", "class Controler(", 2, 1,
        "heating.controller:Controller, the factory of Controller, cannot be imported: "
        "AttributeError: module 'heating.controller' has no attribute 'Controller'"),
    Break("the constructor", "    def on_execute",
        "    def __init__(self, name=None):\n        self.count = len(name) + self.start\n\n"
        "    def on_execute", 2, 14,
        "Controller0.__init__: AttributeError: 'Controller' object has no attribute 'start'"),
    Break("a name", "Power(100.0", "Powr(100.0", 1, 18,
        "Controller0.on_execute at 0.000 s: NameError: name 'Powr' is not defined"),
    Break("the answer", "        return RTC_OK\n", "", 1, 13,
        "Controller0.on_execute at 0.000 s: ReturnValueError: the callback returned None, "
        "which is not a ReturnCode_t: does it end with 'return RTC_OK'?"),
    Break("exit", "            cold =",
        "            raise SystemExit('too hot')\n            cold =", 1, 17,
        "Controller0.on_execute at 0.000 s: SystemExit: too hot"),
    Break("the sample", "self.power.write(Power(100.0 if cold else 0.0))",
        "self.power.write(100.0 if cold else 0.0)", 1, 18,
        "Controller0.on_execute at 0.000 s: SampleTypeError: Controller0.power sends Power, "
        "not float"),
    Break("no sample", "        if measured is not None:\n            cold = measured",
        "        measured = self.temperature.read_newest()\n"
        "        if True:\n            cold = measured", 1, 18,
        "Controller0.on_execute at 0.000 s: AttributeError: 'NoneType' object has no attribute "
        "'value'"),
    Break("waiting", "            cold =",
        "            __import__('threading').Event().wait()\n            cold =", 1, 17,
        "Controller0.on_execute has not returned for 2 s"),
)  # fmt: skip


def files_of(page: str) -> dict[str, str]:
    """Return the files of a page: a comment with the name, then a block."""
    text = (DOCS / page).read_text()
    found = re.findall(
        r"^<!-- page: file (\S+) -->\n```\w+\n(.*?)^```", text, re.MULTILINE | re.DOTALL
    )
    return dict(found)


@cache
def _project() -> Mapping[str, bytes]:
    """Return the files of the project of docs/systems.md after `rtgen generate`."""
    with tempfile.TemporaryDirectory() as temporary:
        folder = Path(temporary)
        for name, text in files_of("systems.md").items():
            file = folder / name
            file.parent.mkdir(parents=True, exist_ok=True)
            file.write_text(text)
        command = [sys.executable, "-m", "rtgen", "generate", "-q", "--no-cache"]
        subprocess.run(command, cwd=folder, check=True)
        return {
            str(file.relative_to(folder)): file.read_bytes()
            for file in folder.rglob("*")
            if file.is_file()
        }


def write(folder: Path) -> None:
    """Write the project of docs/systems.md, as it has been generated once."""
    for name, octets in _project().items():
        file = folder / name
        file.parent.mkdir(parents=True, exist_ok=True)
        file.write_bytes(octets)


def forget_modules() -> None:
    """Forget the project's modules, which other tests import from other folders."""
    for name in list(sys.modules):
        if name.partition(".")[0] in ("heating", "warmth"):
            del sys.modules[name]


def apply(change: Break, folder: Path) -> None:
    """Break the controller of a project."""
    file = folder / CONTROLLER
    text = file.read_text()
    assert change.old in text
    file.write_text(text.replace(change.old, change.new, 1))
