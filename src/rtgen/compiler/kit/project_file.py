"""The file of a project, and what every command looks up in it. Quick to import."""

from __future__ import annotations

from pathlib import Path

from rtgen.compiler.kit.own_files import RENAME_JOURNAL
from rtgen.compiler.kit.translation import LANGUAGES
from rtgen.facts.files import MAX_BYTES, exists, is_file, read_file

FILE_NAME = "rtgen.toml"


def find(folder: Path) -> Path | None:
    """Return the nearest rtgen.toml in the absolute folder or above it."""
    for parent in (folder, *folder.parents):
        file = parent / FILE_NAME
        if is_file(file):
            return file
    return None


def language_of_project() -> str | None:
    """Return the language of texts that the project around the working folder chooses, or None.

    What is wrong with the file is reported where its other settings are read.
    """
    try:
        file = find(Path.cwd())
        data = b"" if file is None else read_file(file, MAX_BYTES)
    except OSError:
        return None
    if b"language" not in data:
        return None
    from rtgen.compiler.kit.toml_text import TomlError, parse

    try:
        table = parse(data.decode("utf-8", "replace"), "").get("rtgen")
    except TomlError:
        return None
    language = table.get("language") if isinstance(table, dict) else None
    return language if language in LANGUAGES else None


def interrupted_rename() -> Path | None:
    """Return the nearest folder around the working folder with the journal of a rename, or None."""
    try:
        here = Path.cwd()
    except FileNotFoundError:  # The folder has been removed.
        return None
    around = (here, *here.parents)
    return next((p for p in around if exists(p / RENAME_JOURNAL)), None)
