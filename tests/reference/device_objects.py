"""The objects of a device of specs/canopen as plain attributes, with the defaults of its EDS."""

from __future__ import annotations

from pathlib import Path
from types import SimpleNamespace
from typing import Any

from rtgen.compiler.frontends.eds import load
from rtgen.compiler.typemap.canopen.names import field_names

FOLDER = Path(__file__).parents[2] / "specs" / "canopen"


def objects(name: str, **values: object) -> Any:
    """Return the attributes by field name; `values` override defaults."""
    result = load([FOLDER / f"{name}.eds"], root=FOLDER)
    assert result.diagnostics == ()
    [device] = result.model.devices
    names = field_names(device.variables)
    made = SimpleNamespace()
    for variable in device.variables:
        setattr(made, names[variable.index, variable.subindex], variable.default)
    for key, value in values.items():
        assert hasattr(made, key), key
        setattr(made, key, value)
    return made
