"""The module `manager`: the manager's component of a project, with its service."""

from __future__ import annotations

from collections.abc import Iterator, Sequence

from rtgen.backends import Options
from rtgen.backends.components.imports import Imports
from rtgen.backends.components.locations import base_location
from rtgen.backends.kit.python_module import (
    PythonModule,
    imports_from,
    python_module,
)
from rtgen.backends.kit.quoting.python import string_literal
from rtgen.model import Component, Model
from rtgen.typemap.python.idl_names import PythonNames

NAME = "CanopenManager"

_TAKEN = frozenset(
    {
        *(NAME, f"{NAME}Base", "NmtCommand", "NodeReport", "_Service", "annotations"),
        *("divmod", "int", "list", "node_id", "report", "self", "time"),
    }
)
_COMMANDS = (
    ("start", "START"),
    ("stop", "STOP"),
    ("enter_pre_operational", "ENTER_PRE_OPERATIONAL"),
    ("reset_node", "RESET_NODE"),
    ("reset_communication", "RESET_COMMUNICATION"),
)
"""Operations of CANopen::Manager, and the NMT commands that they send."""


def manager_module(
    model: Model,
    names: PythonNames,
    options: Options,
    origin: Sequence[str],
    networks: str,
) -> PythonModule:
    """The module. `networks` is the package of the networks."""
    types = Imports(model, names, _TAKEN)
    component = model.find((NAME,))
    assert isinstance(component, Component)
    return python_module(
        f"{options.folder}/canopen/manager.py",
        options.package,
        options.version,
        origin,
        "The manager of the CANopen networks.",
        body="\n".join([*_component(types, networks), "", "", *_service(types)]),
        imports=[
            *imports_from("rtgen.runtime.canopen.master.managed_node", ["NodeReport"]),
            *imports_from("rtgen.runtime.canopen.wire.nmt", ["NmtCommand"]),
            *imports_from(base_location(options.package, component), [f"{NAME}Base"]),
            *types.imports(),
        ],
    )


def _component(types: Imports, networks: str) -> Iterator[str]:
    time = types.type_name(("RTC", "Time"))
    state = types.type_name(("CANopen", "NodeState"))
    phase = types.type_name(("CANopen", "NodePhase"))
    nmt = types.type_name(("CANopen", "NmtState"))
    values = (
        f"{time}(*divmod(time, 1_000_000_000))",
        "report.id",
        "report.name",
        f"{phase}(report.phase)",
        f"{nmt}[report.nmt_name]",
        "report.restarts",
        "report.reason",
    )
    yield f"class {NAME}({NAME}Base):"
    yield '    """Runs one of the networks of this project."""'
    yield ""
    yield f"    networks = {string_literal(networks)}"
    yield ""
    yield f"    def _servant(self) -> {types.type_name(('CANopen', 'Manager'))}:"
    yield "        return _Service(self)"
    yield ""
    yield f"    def _sample(self, report: NodeReport, time: int) -> {state}:"
    yield f"        return {state}({', '.join(values)})"


def _service(types: Imports) -> Iterator[str]:
    state = types.type_name(("CANopen", "NodeState"))
    refused = types.type_name(("CANopen", "Refused"))
    yield f"class _Service({types.type_name(('CANopen', 'Manager'))}):"
    yield f"    def __init__(self, manager: {NAME}) -> None:"
    yield "        self._manager = manager"
    yield ""
    yield f"    def states(self) -> list[{state}]:"
    yield "        return self._manager.reports()"
    for operation, command in _COMMANDS:
        yield ""
        yield f"    def {operation}(self, node_id: int) -> None:"
        yield f"        self._command(NmtCommand.{command}, node_id)"
    yield ""
    yield "    def _command(self, command: NmtCommand, node_id: int) -> None:"
    yield "        reason = self._manager.refusal(command, node_id)"
    yield "        if reason:"
    yield f"            raise {refused}(reason)"
