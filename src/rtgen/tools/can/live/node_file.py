"""Writes the description of a node that has none: its own from 1021h, or one by what it answers."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from pathlib import Path

import msgspec

from rtgen.compiler.diagnostics import ToolError
from rtgen.compiler.frontends import eds
from rtgen.facts.device_files import XML_SUFFIXES
from rtgen.facts.files import absolute_path, check_output, overlaid, write_atomically
from rtgen.tools.can.live.bus_session import BusSession, SilentError
from rtgen.tools.can.live.dictionary_reading import DictionaryReader, Pace
from rtgen.tools.can.live.guessed_device import NodeDescription, describe
from rtgen.tools.kit.exits import Refusal


class NodeFile(msgspec.Struct, frozen=True):
    """The octets of an EDS; `description` is None if the node has stored them itself.

    `stopped` says why objects are missing, and is empty otherwise.
    """

    octets: bytes
    description: NodeDescription | None = None
    stopped: str = ""


def require_new(path: Path) -> None:
    """Raise Refusal for a path that is taken, of XML or in no folder, ToolError for a bad one."""
    if path.suffix.lower() in XML_SUFFIXES:
        raise Refusal(f"-o names an EDS: rtgen convert makes {path.name} of it")
    try:
        check_output(path)
        taken = path.is_symlink() or path.exists()
        placed = path.parent.is_dir()
    except OSError as error:
        raise _unwritable(path, error) from error
    if taken:
        raise Refusal(f"{path} exists: -o names a new file")
    if not placed:
        raise Refusal(f"there is no folder {path.parent}")


def read_node(
    session: BusSession,
    node_id: int,
    path: Path,
    pace: Pace,
    ranges: Sequence[range],
    say: Callable[[str], None],
) -> NodeFile:
    """Read a node; `path` is that of its future file. Raises ToolError."""

    def accepted(octets: bytes) -> bool:
        name = absolute_path(path.with_suffix(".eds"))
        with overlaid({name: octets}):
            result = eds.load([Path(name)], root=path.parent)
        if not result.model.devices:
            say("the EDS stored in 1021h has errors, and is not taken")
        return bool(result.model.devices)

    reader = DictionaryReader(session, node_id, pace, say)
    try:
        reading = reader.read(ranges, accepted)
    except SilentError:
        raise ToolError(
            f"node {node_id} does not answer",
            hint="`rtgen can scan` lists the nodes of the bus; a stopped node has no SDO",
        ) from None
    if reading.stored is not None:
        return NodeFile(reading.stored)
    description = describe(reading, node_id, path.name)
    return NodeFile(description.text.encode(), description, reading.stopped)


def write_new(path: Path, node_file: NodeFile) -> None:
    """Write the file, all at once. Raises Refusal if the path is taken, ToolError."""
    require_new(path)
    try:
        write_atomically(path, node_file.octets)
    except OSError as error:
        raise _unwritable(path, error) from error


def _unwritable(path: Path, error: OSError) -> ToolError:
    return ToolError(f"cannot write {path}: {error.strerror or error}")
