"""The reference build for the target openrtm, generated once for all tests of a process."""

from __future__ import annotations

from pathlib import Path

import pytest

from rtgen.cli import run

ROOT = Path(__file__).resolve().parents[2]


@pytest.fixture(scope="session")
def reference(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """The output folder of the reference build: `<out>/openrtm/<Component>/`, and its packages."""
    folder = tmp_path_factory.mktemp("reference")
    with pytest.MonkeyPatch.context() as patch:
        patch.chdir(ROOT)
        told = ["generate", "specs", "--target", "openrtm", "-o", str(folder), "-q"]
        code = run(told)
    assert code == 0
    return folder / "generated"
