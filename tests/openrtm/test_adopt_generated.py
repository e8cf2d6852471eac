"""`rtgen adopt` of generated modules restores the definition."""

from __future__ import annotations

import shutil
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pytest

from rtgen.cli import run
from rtgen.compiler import compilation
from rtgen.compiler.inspection.models import inspect
from rtgen.compiler.model import Component, Model
from rtgen.compiler.project import load
from rtgen.runtime.opaque_rpc.interface import IDL
from rtgen.tools.components.adopted import Adopted, adopted

ROOT = Path(__file__).parents[2]


def declarations(model: Model) -> dict[str, dict[str, Any]]:
    """Return the output of `inspect --json` for components, without positions."""
    return {
        found["name"]: {k: v for k, v in found.items() if k not in ("file", "line")}
        for found in inspect(model, ())["declarations"]
        if found["kind"] == "component"
    }


def without_annotations(item: Any) -> Any:
    if isinstance(item, list):
        return [without_annotations(each) for each in item]
    if not isinstance(item, dict):
        return item
    kept = {k: v for k, v in item.items() if k != "annotations"}
    return {key: without_annotations(value) for key, value in kept.items()}


def folders(out: Path) -> list[Path]:
    """Return the folders of the IDL files of the reference build."""
    device_files = sorted(path.parent for path in out.glob("refrobots/*/*.idl"))
    boards = [out / "refrobots/tecs/board", IDL.parent]
    own = [*boards, out / "refrobots/canopen", *device_files]
    return [ROOT / "specs/idl", *own]


def modules(out: Path) -> Iterator[Path]:
    for profile in sorted(out.glob("openrtm/*/RTC.xml")):
        yield profile.with_name(f"{profile.parent.name}.py")


def found_in(result: Adopted) -> dict[str, Any]:
    assert isinstance(result.component, Component)
    return declarations(result.model)[result.component.scoped]


@pytest.mark.nightly
def test_the_definition_comes_back(reference: Path) -> None:
    project = load(ROOT)
    defined = declarations(compilation.read(project, lowered=True).model)
    names = set()
    for module in modules(reference):
        result = adopted(module, folders(reference))
        messages = [d.message for d in result.diagnostics if d.code.startswith("RTC05")]
        assert messages == [], module
        found = found_in(result)
        names.add(found["name"])
        wanted = defined.get(found["name"])
        if wanted is not None and wanted["annotations"]:
            assert found == wanted
        elif wanted is not None:
            # Devices: IDL has annotations for fields of the model.
            assert without_annotations(found) == without_annotations(wanted)
    assert names > set(defined)


@pytest.fixture
def follower(reference: Path, tmp_path: Path) -> Path:
    """Return a component's module in a folder of its own, to be changed."""
    source = reference / "openrtm/PathFollower"
    shutil.copytree(
        source, tmp_path / "changed", ignore=shutil.ignore_patterns("stubs")
    )
    return tmp_path / "changed/PathFollower.py"


@pytest.mark.sampled(0)
def test_what_was_changed_wins(follower: Path, reference: Path) -> None:
    text = follower.read_text(encoding="utf-8")
    follower.write_text(
        text.replace('"conf.default.max_v", "1.0"', '"conf.default.max_v", "2.0"'),
        encoding="utf-8",
    )
    result = adopted(follower, folders(reference))
    assert "RTC0565" in [d.code for d in result.diagnostics]
    found = found_in(result)
    assert {c["name"]: c["default"] for c in found["configuration"]}["max_v"] == 2.0


@pytest.mark.sampled(0)
def test_without_its_profile_a_module_says_less(
    follower: Path, reference: Path, capfd: pytest.CaptureFixture[str]
) -> None:
    follower.with_name("RTC.xml").unlink()
    assert run(["adopt", str(follower), "-I", str(ROOT / "specs/idl")]) == 0
    out, _ = capfd.readouterr()
    assert "consumes IIS::TimedPose2D position;" in out
    assert "attribute double max_v;" in out
    assert '@unit("m/s")' not in out
