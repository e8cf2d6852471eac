"""Projects that a test writes, generates and imports."""

from __future__ import annotations

import sys
from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from pathlib import Path

import pytest

from rtgen.cli import run


@contextmanager
def project(
    folder: Path,
    files: Mapping[str, str],
    package: str = "mine",
    *,
    sources: str = "",
    output: str = "",
    python: str = "",
) -> Iterator[Path]:
    """Yield the generated folder of a project, from which modules can be imported.

    `sources`, `output` and `python` are lines of these tables of rtgen.toml.
    """
    folder.mkdir(exist_ok=True)
    for name, text in files.items():
        (folder / name).write_text(text, encoding="utf-8")
    (folder / "rtgen.toml").write_text(
        f'[sources]\npaths = ["."]\n{sources}\n'
        f'[output]\npackage = "{package}"\nskeletons = "{package}_nodes"\n{output}\n'
        f"[python]\n{python}\n",
        encoding="utf-8",
    )
    with pytest.MonkeyPatch.context() as patch:
        patch.chdir(folder)
        assert run(["generate", "-q", "--no-cache"]) == 0
        assert run(["check", "-q", "--no-cache"]) == 0
        patch.syspath_prepend(str(folder / "generated"))
        try:
            yield folder / "generated"
        finally:
            for name in [n for n in sys.modules if n.partition(".")[0] == package]:
                del sys.modules[name]


def modules(generated: Path) -> set[str]:
    """Return the Python files of a tree, without components and empty packages."""
    return {
        path.relative_to(generated).as_posix()
        for path in generated.rglob("*.py")
        if "components" not in path.parts and "import" in path.read_text()
    }
