"""Who changes a room of the compiler or of the runtime can read all that it uses.

A room is a package or module of the wing, a single input language or back end. It uses the modules
that it imports, and those that they import, but not what the stages import by name.
"""

from __future__ import annotations

from collections import defaultdict

import grimp
import pytest
from rtgen_sources import sources

MOST = {"compiler": 42_000, "runtime": 42_000}
"""Maximum number of lines for a room of each wing, with its own."""
MAX_COMMAND = 200
"""Maximum number of lines of a module of the command line."""
DIVIDED = ("compiler.frontends", "compiler.backends")
"""The packages of which each part is a room."""


def _name(path: str) -> str:
    """Return the name of the module in a file below the package `rtgen`."""
    return (
        f"rtgen/{path}".removesuffix(".py").removesuffix("/__init__").replace("/", ".")
    )


LINES = {
    _name(path): len(file.read_text("utf-8").splitlines())
    for path, file in sources().items()
}


def _room(module: str) -> str:
    parts = module.split(".")[1:]
    return ".".join(parts[: 3 if ".".join(parts[:2]) in DIVIDED else 2])


@pytest.mark.parametrize("wing", MOST)
def test_a_room_and_all_that_it_uses_can_be_read(wing: str) -> None:
    graph = grimp.build_graph(
        "rtgen", cache_dir=None, exclude_type_checking_imports=True
    )
    rooms: defaultdict[str, set[str]] = defaultdict(set)
    for module in graph.modules:
        if module.startswith(f"rtgen.{wing}."):
            rooms[_room(module)] |= {module} | graph.find_upstream_modules(module)
    assert len(rooms) > 20
    lines = {
        room: sum(LINES.get(module, 0) for module in modules)
        for room, modules in rooms.items()
    }
    assert max(lines.values()) > 10_000
    assert {room: n for room, n in lines.items() if n > MOST[wing]} == {}


def test_the_modules_of_the_command_line_are_short() -> None:
    commands = {m: n for m, n in LINES.items() if m.startswith("rtgen.cli.")}
    assert len(commands) > 50
    assert {m: n for m, n in commands.items() if n > MAX_COMMAND} == {}
