"""The module `manager`: the manager's component of a project, with its service."""

from __future__ import annotations

from collections.abc import Sequence

from rtgen.compiler.backends import Options
from rtgen.compiler.backends.components.imports import Imports
from rtgen.compiler.backends.components.locations import base_location
from rtgen.compiler.backends.kit.python_module import PythonModule, python_module
from rtgen.compiler.backends.kit.rendering import render
from rtgen.compiler.model import Component, Model
from rtgen.compiler.typemap.python.idl_names import PythonNames

NAME = "CanopenManager"

_TAKEN = frozenset(
    {
        *(NAME, f"{NAME}Base", "NmtCommand", "NodeReport", "_Service", "annotations"),
        *("divmod", "int", "list", "node_id", "report", "self", "time"),
    }
)
_TYPES = ("NodeState", "NodePhase", "NmtState", "Manager", "Refused")
"""The types of the module CANopen that the manager uses."""


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
    body = render(
        "canopen/manager.py.j2",
        base=base_location(options.package, component),
        networks=networks,
        types={
            "Time": types.type_name(("RTC", "Time")),
            **{name: types.type_name(("CANopen", name)) for name in _TYPES},
        },
    )
    return python_module(
        f"{options.folder}/canopen/manager.py",
        options,
        origin,
        "The manager of the CANopen networks.",
        body=body,
        imports=types.imports(),
    )
