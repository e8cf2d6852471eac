"""IDL to RtcProfile to IDL: the component is unchanged, except for edits of the profile."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any

import pytest
from hypothesis import HealthCheck, given, settings
from lxml import etree
from profile_rules import check_schema
from random_components import FILES, Definition, definitions
from seeds import budget

from rtgen.compiler import compilation
from rtgen.compiler.diagnostics import Diagnostic, has_errors
from rtgen.compiler.frontends.kit import located_xml
from rtgen.compiler.frontends.profiles import profile_yaml
from rtgen.compiler.inspection.models import inspect
from rtgen.compiler.model import Component, Model
from rtgen.compiler.project import Project
from rtgen.tools.components.component_text import component_idl, component_profile

ROOT = Path(__file__).parents[3]
SPECS = ROOT / "specs"
REFERENCE = sorted(
    path
    for folder in ("navigation", "canopen", "tecs")
    for path in (SPECS / folder).glob("*.idl")
)
PROFILES = sorted((ROOT / "generated").glob("**/*RTC.xml"))
INCLUDE = (
    SPECS / "idl",
    SPECS / "tecs",
    ROOT / "runtime/src/rtgen/runtime/opaque_rpc",
    ROOT / "generated/refrobots/tecs/board",
    *sorted(p.parent for p in (ROOT / "generated/refrobots").glob("*/*.idl")),
)


class Folder:
    """Writes definitions into a folder and reads them."""

    def __init__(self, path: Path, include: tuple[Path, ...]) -> None:
        self.path = path
        self.include = include

    def read(self, path: Path) -> tuple[Model, Component, list[Diagnostic]]:
        found = compilation.read(self.project(sources=(path,), include=self.include))
        assert not has_errors(found.diagnostics), [d.message for d in found.diagnostics]
        mains = [
            d
            for d in found.model.declarations
            if isinstance(d, Component) and d.file == path.as_posix()
        ]
        return found.model, mains[-1], list(found.diagnostics)

    def project(self, **more: Any) -> Project:
        here = self.path
        return Project(root=here, base=here, output=here, skeletons=here, **more)

    def write(self, name: str, text: str) -> Path:
        path = self.path / name
        path.parent.mkdir(exist_ok=True)
        path.write_text(text, encoding="utf-8", newline="")
        return path

    def profile(self, model: Model, component: Component) -> str:
        return component_profile(model, component, self.project())


def declaration(model: Model, component: Component) -> dict[str, Any]:
    """Return the output of `inspect --json` for a component, without positions."""
    found: dict[str, Any] = next(
        d
        for d in inspect(model, ())["declarations"]
        if (d["name"], d["file"]) == (component.scoped, component.file)
    )
    return {key: value for key, value in found.items() if key not in ("file", "line")}


def told_of_profiles(found: list[Diagnostic]) -> list[str]:
    return [d.message for d in found if d.code.startswith("RTC05")]


def check_round_trip(folder: Folder, path: Path) -> None:
    """Compare XML and YAML, read as definitions, and the IDL written from both."""
    model, component, _ = folder.read(path)
    wanted = declaration(model, component)
    xml = folder.profile(model, component)
    check_schema(etree.fromstring(xml.encode()))
    tree = located_xml.parse(xml, "RTC.xml")
    texts = []
    for name, text in (("a.xml", xml), ("a.yaml", profile_yaml.to_yaml(tree))):
        profile = folder.write(f"out/{name}", text)
        read, made, found = folder.read(profile)
        assert not told_of_profiles(found)
        assert declaration(read, made) == wanted
        assert folder.profile(read, made).partition("-->")[2] == xml.partition("-->")[2]
        texts.append(component_idl(read, made))
    assert texts[0] == texts[1]
    again = folder.write("out/a.idl", texts[0])
    assert declaration(*folder.read(again)[:2]) == wanted


@pytest.mark.sampled(0)
@pytest.mark.parametrize("path", REFERENCE, ids=lambda path: path.stem)
def test_reference_components(path: Path, tmp_path: Path) -> None:
    check_round_trip(Folder(tmp_path, INCLUDE), path)


@pytest.mark.sampled(1)
@pytest.mark.parametrize(
    "path",
    [
        pytest.param(path, marks=pytest.mark.nightly if number % 5 else ())
        for number, path in enumerate(PROFILES)
    ],
    ids=lambda path: path.parent.name,
)
def test_components_of_the_reference_build(path: Path, tmp_path: Path) -> None:
    check_schema(etree.parse(path).getroot())
    folder = Folder(tmp_path, INCLUDE)
    model, component, found = folder.read(path)
    assert not told_of_profiles(found)
    check_round_trip(folder, folder.write("C.idl", component_idl(model, component)))


@pytest.fixture(scope="module")
def folder() -> Iterator[Folder]:
    with TemporaryDirectory() as name:
        made = Folder(Path(name), (Path(name), SPECS / "idl"))
        for file, text in FILES.items():
            made.write(file, text)
        yield made


@given(definitions())
@settings(max_examples=budget(25), suppress_health_check=[HealthCheck.too_slow])
def test_random_components(folder: Folder, definition: Definition) -> None:
    check_round_trip(folder, folder.write("Random.idl", definition.text))


@given(definitions(alone=True))
@settings(max_examples=budget(10), suppress_health_check=[HealthCheck.too_slow])
def test_random_components_beside_their_types(
    folder: Folder, definition: Definition
) -> None:
    check_round_trip(folder, folder.write("Alone.idl", definition.text))
