"""The list of activated components that a supervisor reads after a process was killed."""

from __future__ import annotations

from pathlib import Path
from typing import Any, cast

import pytest

pytest.importorskip("omniORB", reason="omniORBpy is not installed")

from rtgen.runtime.corba.rt_objects.activation import Activations
from rtgen.runtime.return_codes import ACTIVE_STATE, INACTIVE_STATE


class References:
    """In place of an ORB."""

    def text(self, reference: str) -> str:
        return f"IOR:{reference}"


class Device:
    """In place of a component of another process; looks at the list in each of its states."""

    def __init__(self, name: str, file: Path) -> None:
        self.reference, self.context = name, f"{name}.ec"
        self.seen: list[str] = []
        self._file = file
        self._state = INACTIVE_STATE

    def state(self) -> object:
        return self._state

    def activate(self) -> None:
        self.seen.append(self._file.read_text())
        self._state = ACTIVE_STATE


def test_a_component_is_listed_before_it_is_activated_and_at_any_moment_from_then_on(
    tmp_path: Path,
) -> None:
    file = tmp_path / "list"
    activations = Activations(cast(Any, References()), file)
    devices = [Device(name, file) for name in ("base", "arm")]
    lines: list[str] = []
    for device in devices:
        name = device.reference
        activations.activate(name, cast(Any, device))
        lines.append(f"{{}} IOR:{name} IOR:{name}.ec {name}\n")
        assert device.seen == ["".join(lines[:-1]).format(0) + lines[-1].format(1)]
        assert file.read_text() == "".join(lines).format(*[0] * len(lines))
    # A process may be killed between any two steps of a change of the list.
    with file.open() as before:
        activations.forget("arm")
        assert before.read() == "".join(lines).format(0, 0)
    assert file.read_text() == lines[0].format(0)
