"""The IDL front end agrees with omniidl: declarations, repository ids, constants, types."""

import json
import os
from pathlib import Path

import pytest
from idl_facts import facts, omniidl
from programs import needs_omniidl

from rtgen.compiler.diagnostics import Severity, has_errors
from rtgen.compiler.frontends.idl import load
from rtgen.compiler.inspection.models import defined

ROOT = Path(__file__).parents[2]
FILES = sorted(
    path.relative_to(ROOT).as_posix()
    for folder in ("specs/idl", "tests/golden/idl")
    for path in (ROOT / folder).glob("*.idl")
    if "component" not in path.stem and "idl4" not in path.stem
)
CORPUS = os.environ.get("RTGEN_IDL_CORPUS", "")
"""A folder of definition files, one project to a subfolder; none are part of this repository."""

pytestmark = needs_omniidl

Facts = dict[str, object]


def by_name(found: list[Facts]) -> dict[object, Facts]:
    return {fact["name"]: fact for fact in found}


def by_omniidl(path: str, include: list[str], folder: Path) -> list[Facts] | str:
    """Return the facts of omniidl, or its messages if it failed."""
    run = omniidl(path, include, folder)
    if run.returncode != 0:
        return (run.stdout + run.stderr).decode(errors="replace")
    found: list[Facts] = json.loads(run.stdout)
    return found


@pytest.mark.sampled(4)
@pytest.mark.parametrize("path", FILES)
def test_same_declarations(path: str, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(ROOT)
    result = load([Path(path)], root=ROOT, include=[Path("specs/idl")])
    assert not has_errors(result.diagnostics), result.diagnostics
    ours = by_name([facts(d) for d in defined(result.model.declarations)])
    found = by_omniidl(path, ["specs/idl"], ROOT)
    assert isinstance(found, list), found
    theirs = by_name(found)
    assert ours.keys() == theirs.keys()
    for name, fact in theirs.items():
        assert ours[name] == fact


def corpus() -> list[str]:
    """Return the files of the corpus, each content once."""
    folder = Path(CORPUS)
    distinct = {path.read_bytes(): path for path in sorted(folder.rglob("*.idl"))}
    return sorted(path.relative_to(folder).as_posix() for path in distinct.values())


def folders(path: str) -> list[str]:
    """Return the include folders of a file of the corpus: those around it, and the usual ones."""
    around = [folder.as_posix() for folder in Path(path).parents][:-1]
    project = Path(CORPUS) / Path(path).parts[0]
    usual = sorted(
        folder.relative_to(CORPUS).as_posix()
        for name in ("idl", "COS", "include", "interfaces")
        for folder in project.rglob(name)
        if folder.is_dir()
    )
    return list(dict.fromkeys((*around, *usual)))


@pytest.mark.slow
@pytest.mark.skipif(
    not Path(CORPUS or "?").is_dir(),
    reason="RTGEN_IDL_CORPUS names no folder of definition files",
)
def test_same_declarations_in_a_corpus(monkeypatch: pytest.MonkeyPatch) -> None:
    """Files accepted by omniidl have the same facts; others give located findings."""
    folder = Path(CORPUS)
    monkeypatch.chdir(folder)
    differences = []
    for path in corpus():
        include = folders(path)
        result = load([Path(path)], root=folder, include=[*map(Path, include)])
        errors = [d for d in result.diagnostics if d.severity is Severity.ERROR]
        if any(error.span is None for error in errors):
            differences.append(f"{path}: an error has no place")
        theirs = by_omniidl(path, include, folder)
        if not isinstance(theirs, list):
            continue
        if errors:
            differences.append(f"{path}: {errors[0]}")
            continue
        ours = by_name([facts(d) for d in defined(result.model.declarations)])
        for name, fact in by_name(theirs).items():
            if ours.get(name) != fact:
                differences.append(
                    f"{path}: {name}: {ours.get(name)} instead of {fact}"
                )
        differences += [
            f"{path}: {n} is ours only" for n in ours.keys() - by_name(theirs).keys()
        ]
    assert differences == []
