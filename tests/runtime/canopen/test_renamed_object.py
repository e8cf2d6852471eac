"""The extent of changes in the generated tree for one renamed object."""

from __future__ import annotations

from pathlib import Path

import pytest

from rtgen.cli import run

ROOT = Path(__file__).parents[3]
SPECS = ROOT / "specs/canopen"
DEVICES = ("ftmd", "motor_core_unit", "f_palette", "epos_drive")
NETWORKS = ("fourx", "pdo_linking", "rh3_beego")
MAX_CHANGES = 5


def tree(folder: Path, monkeypatch: pytest.MonkeyPatch) -> dict[str, str]:
    """Return the generated files for the definitions of a folder."""
    with monkeypatch.context() as patch:
        patch.chdir(folder)
        assert run(["generate", "--no-cache", "--quiet"]) == 0
    made = folder / "generated"
    return {
        str(path.relative_to(made)): path.read_text(encoding="utf-8")
        for path in made.rglob("*")
        if path.is_file()
    }


@pytest.mark.sampled(0)
@pytest.mark.parametrize(
    ("device", "name"),
    [
        ("ftmd", "Polarity"),
        ("motor_core_unit", "Polarity"),
        ("epos_drive", "Polarity"),
        ("f_palette", "Polarity of inputs 1 to 8"),
    ],
)
def test_of_a_renamed_object_few_files_differ(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, device: str, name: str
) -> None:
    """An object that no PDO maps by default; ports are named after their objects."""
    for file in (*(f"{d}.eds" for d in DEVICES), *(f"{n}.toml" for n in NETWORKS)):
        (tmp_path / file).write_bytes((SPECS / file).read_bytes())
    (tmp_path / "rtgen.toml").write_text(
        '[sources]\npaths = ["."]\n[output]\npackage = "renamed"\n', encoding="utf-8"
    )
    before = tree(tmp_path, monkeypatch)
    described = tmp_path / f"{device}.eds"
    text = described.read_text(encoding="utf-8")
    assert text.count(f"ParameterName={name}\n") == 1
    text = text.replace(f"ParameterName={name}\n", "ParameterName=Another name\n")
    described.write_text(text, encoding="utf-8")
    after = tree(tmp_path, monkeypatch)
    changed = sorted(path for path in before if before[path] != after[path])
    assert before.keys() == after.keys()
    assert f"renamed/{device.replace('_', '')}/__init__.py" in changed
    assert len(changed) <= MAX_CHANGES, changed
