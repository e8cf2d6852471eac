"""The content of docs/ci.md: hooks, a workflow, and output for programs with its schemas."""

from __future__ import annotations

import json
import re
import shlex
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import click
import pytest
import yaml
from json_schemas import SCHEMAS, validator

from rtgen.cli import application, run

ROOT = Path(__file__).parents[3]
PAGE = (ROOT / "docs" / "ci.md").read_text(encoding="utf-8")
BLOCKS = [yaml.safe_load(b) for b in re.findall(r"```yaml\n(.*?)```", PAGE, re.DOTALL)]


def parse(line: str) -> str:
    """Return the command of a line. Raises UsageError for unknown words."""
    _, name, *words = shlex.split(line)
    context = click.Context(application, info_name="rtgen")
    command = application.get_command(context, name)
    assert command is not None, name
    command.make_context(name, words)
    return name


def test_hooks_are_commands_of_rtgen() -> None:
    hooks = yaml.safe_load((ROOT / ".pre-commit-hooks.yaml").read_text("utf-8"))
    for hook in hooks:
        assert {"id", "name", "description", "entry", "language"} <= hook.keys()
        assert hook["language"] == "python"
        assert hook.get("pass_filenames", True) is ("files" in hook)
    commands = [parse(hook["entry"]) for hook in hooks]
    assert commands == ["check", "lint", "fmt", "diff"]
    [form] = [hook["files"] for hook in hooks if "files" in hook]
    assert re.search(form, "specs/a.idl")
    assert not re.search(form, "specs/a.eds")


def test_the_configuration_of_the_page_uses_these_hooks() -> None:
    hooks = yaml.safe_load((ROOT / ".pre-commit-hooks.yaml").read_text("utf-8"))
    [configuration] = [block for block in BLOCKS if "repos" in block]
    [repository] = configuration["repos"]
    used = {hook["id"] for hook in repository["hooks"]}
    assert used == {hook["id"] for hook in hooks}


def test_the_workflow_runs_commands_of_rtgen() -> None:
    [workflow] = [block for block in BLOCKS if "jobs" in block]
    # YAML 1.1 takes the key `on` for true.
    assert set(workflow[True]) == {"pull_request", "push"}
    [job] = workflow["jobs"].values()
    assert job["runs-on"] == "ubuntu-latest"
    lines = [step["run"] for step in job["steps"] if "run" in step]
    commands = [parse(line) for line in lines if line.startswith("rtgen")]
    assert commands == ["check", "lint", "fmt", "diff"]
    [checkout] = [s for s in job["steps"] if "checkout" in s.get("uses", "")]
    assert checkout["with"]["fetch-depth"] == 0  # rtgen diff needs the other revision


def printed(capfd: pytest.CaptureFixture[str], *words: str) -> tuple[Any, Any]:
    """Return the JSON on standard output, None without any, and on standard error."""
    capfd.readouterr()
    run([*words, "--diagnostics", "json"])
    out, err = capfd.readouterr()
    return json.loads(out) if out else None, json.loads(err)


@pytest.mark.sampled(1)
@pytest.mark.parametrize(
    "paths",
    [
        [],
        ["specs/navigation/rh3_goal.xml", "specs/tecs/board.xml"],
        ["specs/canopen/epos_drive.eds", "--node-id", "5"],
        *(
            [str(p)]
            for p in sorted((ROOT / "tests" / "golden" / "idl").glob("*.idl"))[:6]
        ),
    ],
    ids=str,
)
@pytest.mark.sampled(0)
def test_inspected_models_are_valid(
    paths: list[str], monkeypatch: pytest.MonkeyPatch, capfd: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.chdir(ROOT)
    model, findings = printed(capfd, "inspect", "--json", *paths)
    assert model["declarations"]
    validator("inspect.schema.json").validate(model)
    validator("findings.schema.json").validate(findings)


def commands_with_json(group: click.Group, *names: str) -> Iterator[str]:
    """Yield the commands below a group that have the option --json."""
    for name in group.list_commands(click.Context(group)):
        command = group.get_command(click.Context(group), name)
        if isinstance(command, click.Group):
            yield from commands_with_json(command, *names, name)
        elif command and any("--json" in option.opts for option in command.params):
            yield " ".join((*names, name))


def test_each_json_has_a_schema_on_the_page() -> None:
    rows = re.findall(
        r"^\| `rtgen ([^`]+?) --json` \| \[(\S+?)\]\(", PAGE, re.MULTILINE
    )
    assert sorted({command.removesuffix(" --decode") for command, _ in rows}) == sorted(
        commands_with_json(application)
    )
    assert {name for _, name in rows} | {"findings.schema.json"} == {
        path.name for path in SCHEMAS.iterdir()
    }


def test_models_that_say_something_else_are_refused(
    monkeypatch: pytest.MonkeyPatch, capfd: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.chdir(ROOT)
    model, _ = printed(capfd, "inspect", "--json", "specs/idl/intellirobot.idl")
    schema = validator("inspect.schema.json")
    struct = next(d for d in model["declarations"] if d["kind"] == "struct")
    for key, value in (("members", "none"), ("line", 0), ("name", None)):
        kept, struct[key] = struct[key], value
        assert not schema.is_valid(model), key
        struct[key] = kept
    for key in ("members", "repository_id", "doc"):
        kept = struct.pop(key)
        assert not schema.is_valid(model), key
        struct[key] = kept
    assert schema.is_valid(model)


def test_findings_are_valid(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capfd: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.chdir(tmp_path)
    Path("a.idl").write_text("struct S { lon a; };\nstruct S { long b };\n")
    _, findings = printed(capfd, "lint", "a.idl")
    assert {f["severity"] for f in findings} == {"error"}
    assert any(f["related"] for f in findings)
    validator("findings.schema.json").validate(findings)
    _, without_place = printed(capfd, "check")
    assert without_place[0]["file"] is None
    validator("findings.schema.json").validate(without_place)
    findings[0]["severity"] = "bad"
    assert not validator("findings.schema.json").is_valid(findings)


def test_fixes_are_valid(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capfd: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.chdir(tmp_path)
    Path("a.idl").write_text("struct S { long n;; };\n")
    _, [finding] = printed(capfd, "lint", "a.idl")
    assert finding["fix"]["edits"][0]["text"] == ""
    validator("findings.schema.json").validate([finding])
    finding["fix"]["edits"][0]["line"] = 0
    assert not validator("findings.schema.json").is_valid([finding])
