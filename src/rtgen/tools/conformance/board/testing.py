"""Tests a board at a TCP port or a serial line."""

from __future__ import annotations

from collections.abc import Collection
from pathlib import Path
from typing import Final

from rtgen.compiler.diagnostics import ToolError
from rtgen.tools.conformance.board.board import BoardUnderTest
from rtgen.tools.conformance.board.checks import CHECKS
from rtgen.tools.conformance.check import Permission
from rtgen.tools.conformance.report import Outcome, Report, Verdict
from rtgen.tools.conformance.subject import Subject
from rtgen.tools.kit.exits import Refusal
from rtgen.tools.rpc.channels import host_and_port
from rtgen.tools.rpc.signatures import CdlFiles

_GONE: Final = "the board accepts no connection any more"


def tested(file: Path | None, subject: Subject) -> Report:
    """Return the report of all checks. Raises InputError, Refusal and ToolError."""
    cdl, signature, functions = CdlFiles(file), subject.signature, subject.functions
    if signature is None:
        names = [str(each.scoped) for _, each in cdl.signatures()]
        place = file or "the project"
        if not names:
            raise Refusal(f"{place} has no signature")
        if len(names) > 1:
            raise Refusal(
                f"{place} has several signatures; --signature names one: {', '.join(names)}"
            )
        [signature] = names
    service = cdl.service(signature, subject.wire)
    unknown = [name for name in functions if name not in service.functions]
    if unknown:
        choices = ", ".join(service.functions)
        raise Refusal(f"{signature} has no function {unknown[0]!r}; it has: {choices}")
    kind, _, rest = subject.connect.partition(":")
    if kind not in ("tcp", "serial") or not rest:
        raise Refusal(f"{subject.connect!r} is neither tcp:HOST:PORT nor serial:DEVICE")
    board = BoardUnderTest(
        service,
        {n: f for n, f in service.functions.items() if not functions or n in functions},
        host_and_port(rest) if kind == "tcp" else None,
        rest if kind == "serial" else None,
        subject.baud,
        subject.timeout,
        stall=subject.stall,
    )
    definition = service.signature.file if file is None else file.as_posix()
    name = f"{signature} at {rest}"
    return checked(board, name, definition, subject.permissions)


def checked(
    board: BoardUnderTest,
    subject: str,
    definition: str,
    permissions: Collection[Permission],
) -> Report:
    """Return the report of all checks of a board. Raises ToolError if it cannot be reached."""
    why = board.absence()
    if why is not None:
        raise ToolError(f"{subject}: {why}")
    outcomes: list[Outcome] = []
    is_gone = False
    for check in CHECKS:
        if is_gone:
            outcomes.append(check.skipped(_GONE))
            continue
        outcomes.append(check.outcome(board, permissions))
        is_gone = outcomes[-1].verdict is Verdict.FAILED and board.absence() is not None
    report = Report(subject, definition, tuple(outcomes))
    if all(o.verdict is Verdict.SKIPPED for o in outcomes):
        raise ToolError(
            f"{subject}: no answer, and no check that does without",
            hint="--actuate calls functions, --function NAME only that one",
        )
    return report
