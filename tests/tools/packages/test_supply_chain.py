"""Supply chain of a release: requirements with bounds, locked versions, licences, the workflow."""

from __future__ import annotations

import importlib
import json
import re
import subprocess
import tomllib
from itertools import chain
from pathlib import Path
from typing import Any

import pytest
import yaml
from packaging.requirements import Requirement
from packaging.utils import canonicalize_name

from rtgen.facts.version import __version__

ROOT = Path(__file__).parents[3]
PYPROJECT = tomllib.loads((ROOT / "pyproject.toml").read_text("utf-8"))
PROJECT = PYPROJECT["project"]
FRAGMENTS = ROOT / "changelog.d"
EXTRAS: dict[str, list[str]] = PROJECT["optional-dependencies"]
RUNTIME = tomllib.loads((ROOT / "runtime" / "pyproject.toml").read_text("utf-8"))[
    "project"
]
SPEED = tomllib.loads((ROOT / "speed" / "pyproject.toml").read_text("utf-8"))["project"]
OWN = {"rtgen", "rtgen-runtime", "rtgen-speed"}


def resolved(needs: list[str]) -> list[Requirement]:
    """Return requirements; for an extra of the runtime, those of that extra."""
    found = []
    for need in map(Requirement, needs):
        if need.name not in OWN:
            found.append(need)
        elif need.name == "rtgen-runtime":
            for extra in need.extras:
                found += resolved(RUNTIME["optional-dependencies"][extra])
    return found


TESTED = resolved(
    [
        *PROJECT["dependencies"],
        *RUNTIME["dependencies"],
        *EXTRAS["plot"],
        *EXTRAS["test"],
        *EXTRAS["release"],
    ]
)
WORKSHOP = {"test", "check", "bench", "release"}


@pytest.mark.parametrize("group", ["", *EXTRAS])
def test_each_requirement_has_a_lower_bound(group: str) -> None:
    needs = EXTRAS[group] if group else PROJECT["dependencies"]
    for need in map(Requirement, needs):
        if need.name == PROJECT["name"]:
            continue
        bounds = {each.operator for each in need.specifier}
        assert bounds & {">=", "=="}, f"{need} has no lower bound"


def test_a_requirement_has_one_bound_in_all_extras() -> None:
    found: dict[str, set[str]] = {}
    for project in (PROJECT, RUNTIME):
        groups = project["optional-dependencies"].values()
        for need in map(Requirement, (*project["dependencies"], *chain(*groups))):
            if need.name == "rtgen":
                continue
            name = canonicalize_name(need.name)
            found.setdefault(name, set()).add(str(need.specifier))
    assert {name: bounds for name, bounds in found.items() if len(bounds) > 1} == {}


def test_locked_versions_fit_the_requirements() -> None:
    """`make lock` renews them."""
    locked: dict[str, list[Requirement]] = {}
    text = (ROOT / "requirements" / "locked.txt").read_text("utf-8")
    for line in text.splitlines():
        entry = Requirement(line)
        locked.setdefault(canonicalize_name(entry.name), []).append(entry)
    for need in TESTED:
        entries = locked.get(canonicalize_name(need.name), [])
        assert entries, f"{need.name} is not locked"
        for entry in entries:
            [pinned] = entry.specifier
            assert pinned.operator == "=="
            assert need.specifier.contains(pinned.version), f"{entry} is not {need}"


def test_builds_have_locked_tools() -> None:
    """A wheel names the version of its build back end, and contains what the tools make."""
    locked = (ROOT / "requirements" / "locked.txt").read_text("utf-8")
    names = {canonicalize_name(Requirement(line).name) for line in locked.splitlines()}
    for project in (ROOT, ROOT / "runtime"):
        content = tomllib.loads((project / "pyproject.toml").read_text("utf-8"))
        needs = map(Requirement, content["build-system"]["requires"])
        assert {canonicalize_name(need.name) for need in needs} <= names
    (makefile,) = re.findall(
        r"^wheels:(?:.*\n\t?wheels:)*.*", (ROOT / "Makefile").read_text(), re.MULTILINE
    )
    for variable in ("PIP_CONSTRAINT", "PIP_BUILD_CONSTRAINT"):
        assert f"export {variable} = $(CURDIR)/$(LOCK)" in makefile


def test_licences_are_those_of_the_requirements() -> None:
    """`make licences` renews the page."""
    text = (ROOT / "requirements" / "licences.md").read_text("utf-8")
    text = text.partition("npm packages")[0]
    rows = re.findall(r"^\| (\S+) \| (\S+) \| (.+) \|$", text, re.MULTILINE)
    listed = {(extra, name) for extra, name, _ in rows if not extra.startswith("-")}
    groups = {"(always)": PROJECT["dependencies"], **EXTRAS}
    assert listed - {("extra", "package")} == {
        (extra, need.name)
        for extra, needs in groups.items()
        if extra not in WORKSHOP
        for need in resolved(needs)
    }
    assert not [row for row in rows if "UNKNOWN" in row[2]]


def test_licences_are_those_of_the_page() -> None:
    """`make licences` renews them after a change of the page's dependencies."""
    text = (ROOT / "requirements" / "licences.md").read_text("utf-8")
    text = text.partition("npm packages")[2]
    rows = re.findall(r"^\| (\S+) \| (\d\S*) \| (.+) \|$", text, re.MULTILINE)
    listed = {name: version for name, version, _ in rows}
    lock = json.loads((ROOT / "ui" / "package-lock.json").read_text("utf-8"))
    packages = lock["packages"]
    assert packages[""]["dependencies"].items() <= listed.items()
    for name, version in listed.items():
        entry = packages[f"node_modules/{name}"]
        assert entry["version"] == version
        assert not entry.get("dev")


def test_a_bill_of_materials_has_the_packages_of_the_page(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.syspath_prepend(ROOT / "requirements")
    page = importlib.import_module("page")
    licences = tmp_path / "licenses.md"
    licences.write_text(
        "# Licenses\n\n## @a/b - 1.2.0 (EPL-2.0 OR MIT)\n\n## 1. TERMS\n"
    )
    monkeypatch.setattr(page, "LICENSES", licences)
    bill: dict[str, Any] = {
        "components": [{"bom-ref": "lark==1.3.1"}],
        "dependencies": [
            {"ref": "lark==1.3.1"},
            {"ref": "root", "dependsOn": ["lark==1.3.1"]},
        ],
        "metadata": {"component": {"bom-ref": "root", "name": "rtgen"}},
    }
    page.complete(bill, "3.2.1", page.packages())
    url = "pkg:npm/%40a/b@1.2.0"
    assert bill["metadata"]["component"]["version"] == "3.2.1"
    assert bill["dependencies"][1:] == [
        {"ref": "root", "dependsOn": ["lark==1.3.1", url]},
        {"ref": url},
    ]
    [_, added] = bill["components"]
    assert (added["name"], added["purl"]) == ("@a/b", url)
    assert added["licenses"][0]["expression"] == "EPL-2.0 OR MIT"


def test_the_workflow_of_a_release_calls_what_there_is() -> None:
    text = (ROOT / ".github" / "workflows" / "release.yml").read_text("utf-8")
    workflow = yaml.safe_load(text)
    jobs = workflow["jobs"]
    assert [jobs[name].get("needs") for name in ("test", "build", "publish")] == [
        None,
        "test",
        ["build", "speed"],
    ]
    [wheels] = (
        s for s in jobs["speed"]["steps"] if "cibuildwheel" in s.get("uses", "")
    )
    assert (ROOT / wheels["with"]["package-dir"] / "pyproject.toml").is_file()
    runs = [
        step["run"] for job in jobs.values() for step in job["steps"] if "run" in step
    ]
    commands = jobs["test"]["strategy"]["matrix"]["command"]
    runs = [
        run.replace("${{ matrix.command }}", command)
        for run in runs
        for command in commands
    ]
    called = {found[1] for run in runs for found in re.finditer(r"\bmake (\S+)", run)}
    assert called == {"test", "nightly", "lowest", "release"}
    for target in called:
        subprocess.run(
            ["make", "--dry-run", target], cwd=ROOT, check=True, capture_output=True
        )
    assert jobs["publish"]["permissions"]["id-token"] == "write"
    assert workflow["permissions"] == {"contents": "read"}


def test_each_night_runs_what_a_commit_leaves_out() -> None:
    text = (ROOT / ".github" / "workflows" / "ci.yml").read_text("utf-8")
    workflow = yaml.safe_load(text)
    assert workflow[True]["schedule"]
    [command] = [s["run"] for s in workflow["jobs"]["test"]["steps"] if "run" in s]
    assert "== 'schedule' && format('nightly RTGEN_SEED=" in command
    lines = (ROOT / ".ci" / "run").read_text("utf-8").splitlines()
    assert lines[-2:] == ["make test", "make nightly"]


KINDS = {kind["directory"] for kind in PYPROJECT["tool"]["towncrier"]["type"]}


def test_a_fragment_of_the_changelog_is_one_line() -> None:
    for file in FRAGMENTS.glob("[!.]*"):
        name = re.fullmatch(r"\+[a-z0-9-]+\.(\w+)\.md", file.name)
        assert name is not None, file.name
        assert name[1] in KINDS, file.name
        text = file.read_text("utf-8")
        assert re.fullmatch(r"[A-Z`].{10,160}\.\n", text), text


def test_the_two_distributions_are_of_one_version() -> None:
    """rtgen and its extras require the runtime that is built with it."""
    needs = [*PROJECT["dependencies"], *chain(*EXTRAS.values())]
    own = [r for r in map(Requirement, needs) if r.name == "rtgen-runtime"]
    assert {str(r.specifier) for r in own} == {f"=={__version__}"}
    assert {e for r in own for e in r.extras} == RUNTIME["optional-dependencies"].keys()


def test_the_codecs_in_c_are_of_that_version() -> None:
    assert SPEED["version"] == __version__
    [needed] = map(Requirement, RUNTIME["optional-dependencies"]["speed"])
    assert (needed.name, str(needed.specifier)) == (SPEED["name"], f"=={__version__}")
    assert SPEED["requires-python"] == RUNTIME["requires-python"]


def test_all_extras_of_users_are_in_one() -> None:
    [every] = map(Requirement, EXTRAS["all"])
    assert every.name == "rtgen"
    needing_a_compiler = {"speed"}
    assert every.extras == EXTRAS.keys() - WORKSHOP - {"all"} - needing_a_compiler


def test_the_changelog_is_short_and_its_links_lead_somewhere() -> None:
    text = (ROOT / "CHANGELOG.md").read_text("utf-8")
    versions = re.findall(r"^## (\S+)", text, re.MULTILINE)
    assert versions[0] == __version__
    assert len(text.splitlines()) <= 80 * len(versions)
    for page in re.findall(r"\]\((docs/[^)#]+)", text):
        assert (ROOT / page).is_file(), page
