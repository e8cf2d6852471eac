"""Tests a node, a board or a component against the definition in a file, by the file's kind."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING

from rtgen.compiler.diagnostics import ToolError
from rtgen.facts.cdl_files import CDL_SUFFIXES
from rtgen.facts.device_files import DEVICE_SUFFIXES
from rtgen.facts.extras import installation
from rtgen.facts.idl_files import IDL_SUFFIXES
from rtgen.tools.conformance.subject import Subject
from rtgen.tools.kit.console import Console
from rtgen.tools.kit.exits import Refusal

if TYPE_CHECKING:
    from rtgen.tools.conformance.report import Report

_COMPONENTS = (*IDL_SUFFIXES, ".xml", ".yaml", ".yml")


def is_of_node(file: Path | None, connect: str) -> bool:
    """Return whether a file, or else an address, is that of a node, which is on a bus.

    Raises Refusal for other files.
    """
    if file is None:
        return not _is_of_board(file, connect) and not _is_of_component(connect)
    suffix = file.suffix.lower()
    if suffix not in (*DEVICE_SUFFIXES, *CDL_SUFFIXES, *_COMPONENTS):
        raise Refusal(
            f"{file} is not a description of a device, a CDL file or the definition of a component"
        )
    return suffix in DEVICE_SUFFIXES


def _is_of_board(file: Path | None, connect: str) -> bool:
    if file is not None:
        return file.suffix.lower() in CDL_SUFFIXES
    return connect.startswith(("tcp:", "serial:"))


def _is_of_component(connect: str) -> bool:
    """Return whether an address is that of a component: of CORBA, or `HOST[:PORT]/NAME.rtc`."""
    return connect.lower().startswith(("corbaname:", "corbaloc:", "ior:")) or (
        "/" in connect and connect.endswith(".rtc")
    )


def tested(file: Path | None, subject: Subject, console: Console) -> Report:
    """Return the report of all checks. Raises InputError, Refusal, ReportedError, ToolError.

    Without a file, the definition is one of the project's, according to the address.
    """
    if is_of_node(file, subject.connect):
        from rtgen.tools.conformance.canopen import testing as nodes

        if file is None:
            file, subject = nodes.of_project(subject, console)
        return nodes.tested(file, subject)
    if _is_of_board(file, subject.connect):
        from rtgen.tools.conformance.board import testing as boards

        return boards.tested(file, subject)
    try:
        from rtgen.tools.conformance.rtc import testing as components
    except ImportError as error:
        raise ToolError(
            "a test of a component needs omniORBpy, which is not installed",
            hint=installation("corba"),
        ) from error
    return components.tested(file, subject)
