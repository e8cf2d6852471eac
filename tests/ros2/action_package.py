"""The package generated from the action `lab/action/Go` and components that have it."""

from __future__ import annotations

import importlib
from pathlib import Path
from types import ModuleType

import pytest

from rtgen.cli import run as rtgen

ACTION = "float64 x\n---\nbool done\n---\nfloat64 left\n"
MODULES = (
    *("lab.action", "action_msgs.srv", "action_msgs.msg", "unique_identifier_msgs.msg"),
    *("components.mover", "components.asker"),
)


def generated(folder: Path, idl: str, package: str) -> ModuleType:
    """Return the package generated in a folder; `idl` has the components Mover and Asker."""
    with pytest.MonkeyPatch.context() as patch:
        patch.chdir(folder)
        Path("lab/action").mkdir(parents=True)
        Path("lab/action/Go.action").write_text(ACTION)
        Path("t.idl").write_text(idl)
        Path("rtgen.toml").write_text(
            f'[sources]\npaths = ["t.idl", "lab"]\n[output]\npackage = "{package}"\n'
        )
        assert rtgen(["generate", "-q", "--no-cache"]) == 0
        patch.syspath_prepend(str(folder / "generated"))
        for name in MODULES:
            importlib.import_module(f"{package}.{name}")
        return importlib.import_module(package)
