"""More findings than are shown: for warnings that is a note, and does not fail."""

from __future__ import annotations

from pathlib import Path

from rtgen.cli import run


def test_more_than_a_thousand_warnings_do_not_fail(tmp_path: Path) -> None:
    file = tmp_path / "a.cdl"
    types = "".join(f"celltype t{i} {{ call sA cA; }};\n" for i in range(1_100))
    file.write_text(f"signature sA {{ void f(void); }};\n{types}")
    assert run(["generate", "-q", "-o", str(tmp_path / "out"), str(file)]) == 0
    assert (tmp_path / "out").exists()
