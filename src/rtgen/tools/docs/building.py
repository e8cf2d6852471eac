"""Builds a site with MkDocs."""

from __future__ import annotations

import os
import subprocess
import sys
from collections.abc import Sequence
from importlib.util import find_spec
from pathlib import Path
from tempfile import TemporaryDirectory

from rtgen.compiler.diagnostics import ToolError
from rtgen.facts.extras import installation
from rtgen.facts.files import make_folder
from rtgen.tools.docs.pages import File

_MARK = ".rtgen-site"
"""File in a folder that a site was built in; MkDocs leaves hidden files alone."""
_OF_PAGES = (".rtgen.json", "mkdocs.yml")
"""Files in a folder that rtgen has written pages to."""


def build(files: Sequence[File], target: Path) -> None:
    """Build the site of some pages in a folder of its own, whose content it replaces.

    Raises ToolError for a folder with other files, and if MkDocs is missing or fails.
    """
    if find_spec("material") is None or find_spec("mkdocs") is None:
        raise ToolError(
            "MkDocs with the theme Material is missing",
            hint=installation("docs"),
        )
    _require_own(target)
    with TemporaryDirectory(prefix="rtgen-docs-") as name:
        for file in files:
            path = Path(name, file.path)
            make_folder(path.parent)
            path.write_text(file.text, encoding="utf-8", newline="\n")
        _run_mkdocs(Path(name), target)


def _require_own(target: Path) -> None:
    """Mark a folder as that of a site. Raises ToolError if it has other files."""
    try:
        make_folder(target)
        names = {path.name for path in target.iterdir()}
        if names and _MARK not in names and not names.issuperset(_OF_PAGES):
            raise ToolError(
                f"{target.as_posix()} holds other files, which a site would replace",
                hint="-o names a folder of the site's own",
            )
        (target / _MARK).touch()
    except OSError as error:
        message = f"cannot write {target.as_posix()}: {error.strerror}"
        raise ToolError(message) from error


def _run_mkdocs(source: Path, target: Path) -> None:
    command = [sys.executable, "-m", "mkdocs", "build", "--strict", "--quiet"]
    command += ["--site-dir", str(target.absolute())]
    # Pages bear the date of the build otherwise.
    environment = {**os.environ, "SOURCE_DATE_EPOCH": "0", "NO_MKDOCS_2_WARNING": "1"}
    done = subprocess.run(
        command,
        cwd=source,
        env=environment,
        capture_output=True,
        text=True,
        check=False,
    )
    if done.returncode != 0:
        last = (done.stderr.strip() or done.stdout.strip()).splitlines()[-1:]
        raise ToolError(f"mkdocs: {' '.join(last)}")
