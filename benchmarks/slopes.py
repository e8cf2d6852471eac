"""Growth of the costs of each command from 1 to 4 to 16 times the input.

    python benchmarks/slopes.py [--only SHAPE] [--time]

Costs are lines of Python that a command executes in this process, after a run on a smaller input
has imported all modules: equal on every machine, whatever else runs there. A figure of the table is
the cost of 16 times the input, without what any input costs: 4 (c16 - c4) / (c4 - c1), 16 if each
item costs the same, 64 if each pair does. Exits with 1 if one is above the limit. `slopes_shapes`
has the inputs; `lsp` is an edit up to its diagnostics, `ui` the start up to the first message for a
page, `run` a simulated second.

With `--time` the figures are those of processor time, which also has what the lines do in C.
"""

from __future__ import annotations

import io
import os
import sys
import tempfile
import threading
import time
from collections.abc import Callable, Iterator
from contextlib import (
    ExitStack,
    chdir,
    contextmanager,
    redirect_stderr,
    redirect_stdout,
)
from pathlib import Path
from types import FrameType
from typing import Any

from lsprotocol.types import Position, Range, TextDocumentContentChangePartial
from slopes_shapes import COMMANDS, SHAPES, Files, Shape
from tables import Arguments, Results

from rtgen import runtime
from rtgen.cli import run
from rtgen.tools.kit.console import Console
from rtgen.tools.lsp.documents import uri_of
from rtgen.tools.lsp.workspace import Workspace
from rtgen.ui.outbox import Outbox
from rtgen.ui.project_systems import CommandProject
from rtgen.ui.session import Session

FACTORS = (1, 4, 16)
LIMIT = 20.0
"""Maximum cost of 16 times the input, relative to the input."""

SETTINGS = """\
[sources]
paths = ["definitions"{}]
include = ["definitions", "included"]
[output]
package = "lab"
skeletons = "lab_nodes"
"""
SYSTEM = "systems/system.xml"
WORDS = {
    "generate": "generate -q --no-cache",
    "check": "check --no-cache",
    "lint": "lint",
    "fmt": "fmt",
    "diff": "diff ../before/definitions definitions",
    "docs": "docs -q",
    "inspect": "inspect --no-cache",
    "graph": f"graph {SYSTEM} -o system.svg",
    "run": f"run {SYSTEM} --until 1 -q",
}

GENERATED = ("check", "run", "ui")
"""The commands that need generated files."""

Deed = Callable[[], object]


class Lines:
    """Counts the lines of Python that are executed meanwhile, in all threads."""

    def __init__(self) -> None:
        self.cost = 0.0

    def __enter__(self) -> Lines:
        threading.settrace(self._called)
        sys.settrace(self._called)
        return self

    def __exit__(self, *_: object) -> None:
        sys.settrace(None)
        threading.settrace(None)

    def _called(self, frame: FrameType, event: str, value: object) -> Any:
        return self._line

    def _line(self, frame: FrameType, event: str, value: object) -> Any:
        self.cost += 1
        return self._line


class Seconds:
    """Measures the processor time of this process meanwhile [s]."""

    cost = 0.0

    def __enter__(self) -> Seconds:
        self.cost -= time.process_time()
        return self

    def __exit__(self, *_: object) -> None:
        self.cost += time.process_time()


def write(folder: Path, files: Files) -> None:
    """Write the files of a project, and its settings."""
    systems = ', "systems"' if SYSTEM in files else ""
    texts = {**files, "rtgen.toml": SETTINGS.format(systems)}
    (folder / "included").mkdir(parents=True)
    for name, text in texts.items():
        path = folder / name
        path.parent.mkdir(parents=True, exist_ok=True)
        path.write_text(text, encoding="utf-8")


@contextmanager
def project(shape: Shape, size: int, *, generated: bool) -> Iterator[None]:
    """Work in a project, with an earlier version in `../before`."""
    modules, path = set(sys.modules), list(sys.path)
    with ExitStack() as stack:
        name = stack.enter_context(tempfile.TemporaryDirectory())
        os.environ["RTGEN_CACHE_DIR"] = f"{name}/cache"
        for number, version in enumerate(("before", "now")):
            write(Path(name, version), shape.make(size, number))
        stack.enter_context(chdir(Path(name, "now")))
        if generated:
            finish(lambda: run(["generate", "-q"]))
        yield
    sys.path[:] = path
    for name in set(sys.modules) - modules:
        if name.partition(".")[0] in ("lab", "lab_nodes"):
            del sys.modules[name]


def finish(deed: Deed) -> None:
    """Do something whose output is not shown. Raises RuntimeError if it fails."""
    with io.TextIOWrapper(io.BytesIO(), write_through=True) as output:
        with redirect_stdout(output), redirect_stderr(output):
            code = deed()
        if code not in (None, 0, 1):
            text = output.buffer.getvalue().decode()
            raise RuntimeError(f"exit code {code}: {text[-1000:]}")


def deed_of(command: str, shape: Shape) -> Deed:
    """Return what a command does; what its costs do not include is done at once."""
    if command == "ui":
        return first_message
    if command == "lsp":
        return edit()
    words = WORDS[command].split()
    if command == "inspect" and "graph" in shape.commands:
        words.append(SYSTEM)
    return lambda: run(words)


def first_message() -> None:
    """Open a system, and make the first message for a page."""
    project = CommandProject(Console("text", False, True), [SYSTEM])
    session = Session(project, SYSTEM, runtime.SimulatedClock)
    page = Outbox(lambda: None, full=True)
    session.join(page)
    page.take()
    session.close()


def edit() -> Deed:
    """Open a file in the language server; return an edit that waits for its diagnostics."""
    workspace = Workspace()
    path = min(Path("definitions").absolute().iterdir())
    uri = uri_of(str(path))
    workspace.documents.open(uri, 1, path.read_text(encoding="utf-8"))
    key = workspace.key_of(str(path))

    def analyse() -> None:
        workspace.analyse(key)
        workspace.emit(key)

    def change() -> None:
        start = Position(0, 0)
        text = ";\n" if path.suffix == ".eds" else "\n"
        edits = [TextDocumentContentChangePartial(Range(start, start), text)]
        workspace.documents.change(uri, 2, edits)
        analyse()

    analyse()
    return change


def cost(shape: Shape, size: int, command: str, meter: type[Lines | Seconds]) -> float:
    """Return the cost of a command."""
    with project(shape, size, generated=command in GENERATED):
        deed = deed_of(command, shape)
        with meter() as measured:
            finish(deed)
        return measured.cost


def growth(costs: list[float]) -> float:
    """Return how many times the cost of the input that of 16 times the input is."""
    small, medium, large = costs
    return 4 * (large - medium) / (medium - small) if medium > small else 0.0


def main() -> int:
    """Print the table; return 1 if a figure is above the limit."""
    arguments = Arguments(__doc__, rounds=1)
    arguments.add_argument("--only", choices=SHAPES, metavar="SHAPE")
    arguments.add_argument("--time", action="store_true")
    chosen = arguments.parse_args()
    meter = Seconds if chosen.time else Lines
    shapes = {chosen.only: SHAPES[chosen.only]} if chosen.only else SHAPES
    if chosen.smallest:
        shapes = {name: SHAPES[name] for name in list(shapes)[:1]}
    above = False
    with Results(__file__, chosen) as results:
        columns = [(command, ".1f") for command in COMMANDS]
        table = results.table("growth", "input", ("items", "s"), *columns)
        for name, shape in shapes.items():
            size = max(2, shape.size // 8) if chosen.smallest else shape.size
            figures: list[float | None] = []
            for command in COMMANDS:
                if command not in shape.commands:
                    figures.append(None)
                    continue
                cost(shape, 2, command, Seconds)
                costs = [cost(shape, size * k, command, meter) for k in FACTORS]
                figures.append(growth(costs))
            above |= max(filter(None, figures)) > LIMIT
            table.add(name, f"{size} to {16 * size:,}", *figures)
    print(f"each at most {LIMIT:g}: {'no' if above else 'yes'}")
    return int(above and not chosen.time)


if __name__ == "__main__":
    sys.exit(main())
