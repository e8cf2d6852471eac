"""Several hundred probes of single rules of the language, compared with omniidl where possible."""

import json
from collections.abc import Sequence
from pathlib import Path
from typing import Any

import pytest
from idl_facts import facts, omniidl_batch
from idl_probes import SECTIONS
from idl_probes.probe import Probe, Relation
from msgspec.structs import replace

from rtgen.compiler.frontends import FrontendResult
from rtgen.compiler.frontends.idl import load
from rtgen.compiler.inspection.models import defined, tree

pytest.importorskip("omniidl", reason="omniidl (jeteve-omniorb) is missing")


def write(probe: Probe, folder: Path) -> None:
    folder.mkdir()
    for name, text in {**probe.files, "input.idl": probe.text}.items():
        path = folder / name
        path.parent.mkdir(exist_ok=True)
        path.write_bytes(text if isinstance(text, bytes) else text.encode())


def answers(probes: Sequence[Probe], folder: Path) -> list[dict[str, Any] | None]:
    """Return omniidl's answer to each probe; None for those without comparison."""
    asked = [
        {
            "folder": str(folder / str(number)),
            "file": "input.idl",
            "arguments": [f"-I{name}" for name in probe.folders]
            + ["-nc"] * probe.ignore_case,
        }
        for number, probe in enumerate(probes)
        if probe.relation is not Relation.ALONE
    ]
    found = iter(omniidl_batch(asked))
    return [None if p.relation is Relation.ALONE else next(found) for p in probes]


def summary(result: FrontendResult) -> dict[str, str]:
    """Return each declaration as one line of `inspect`; `<name> id` is its repository id."""
    shown = {}
    for file in result.model.files:
        blocks: list[list[str]] = []
        for line in tree(replace(result.model, files=(file,))).splitlines()[1:]:
            if line.startswith("    "):
                blocks[-1].append(line.strip())
            else:
                blocks.append([line.strip()])
        declarations = result.model.of_file(file.name)
        for declaration, block in zip(declarations, blocks, strict=True):
            shown[declaration.scoped] = "; ".join(block)
            shown[f"{declaration.scoped} id"] = declaration.repository_id
    return shown


def differences(
    probe: Probe, result: FrontendResult, answer: dict[str, Any] | None
) -> list[str]:
    """Return the differences from the probe's expectation."""
    found = []
    codes = tuple(d.code for d in result.diagnostics)
    if len(codes) != len(probe.codes) or not all(
        map(str.startswith, codes, probe.codes)
    ):
        reported = "; ".join(f"{d.code} {d.message}" for d in result.diagnostics)
        found.append(f"{probe.codes} expected, but: {reported or 'accepted'}")
    if answer is not None:
        accepts = answer["status"] == 0
        if accepts != (probe.relation in (Relation.SAME, Relation.STRICTER)):
            verb = "accepts" if accepts else "refuses"
            found.append(f"omniidl {verb} it: {answer['messages']}")
        elif probe.relation is Relation.SAME:
            found += unequal(result, answer["facts"])
    shown = summary(result) if probe.gives else {}
    for name, text in probe.gives.items():
        if shown.get(name) != text:
            found.append(f"{name}: {text!r} expected, not {shown.get(name)!r}")
    return found


def unequal(result: FrontendResult, theirs: list[dict[str, Any]]) -> list[str]:
    """Return the differences between declarations and omniidl's."""
    ours = {d.scoped: facts(d) for d in defined(result.model.declarations)}
    others = {fact["name"]: fact for fact in theirs}
    return [
        f"{name}: ours {json.dumps(ours.get(name))}, theirs {json.dumps(others.get(name))}"
        for name in ours | others
        if ours.get(name) != others.get(name)
    ]


@pytest.mark.nightly
@pytest.mark.parametrize("section", SECTIONS)
def test_probes(section: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    probes = SECTIONS[section]
    for number, probe in enumerate(probes):
        write(probe, tmp_path / str(number))
    wrong = []
    for number, answer in enumerate(answers(probes, tmp_path)):
        probe = probes[number]
        monkeypatch.chdir(tmp_path / str(number))
        result = load(
            [Path("input.idl")],
            root=Path.cwd(),
            include=[Path(name) for name in probe.folders],
            ignore_case_clashes=probe.ignore_case,
        )
        wrong += [
            f"{probe.name}: {text}" for text in differences(probe, result, answer)
        ]
    assert not wrong, "\n".join(["", *wrong])


@pytest.mark.parametrize("section", SECTIONS)
def test_probes_have_their_own_names(section: str) -> None:
    names = [probe.name for probe in SECTIONS[section]]
    assert len(set(names)) == len(names)
