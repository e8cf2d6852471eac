"""The language of texts that a project chooses: `[rtgen] language`."""

from __future__ import annotations

from pathlib import Path

from rtgen.compiler.kit.toml_text import TomlError, parse
from rtgen.compiler.kit.translation import LANGUAGES
from rtgen.compiler.project.paths import find
from rtgen.facts.files import MAX_BYTES, read_file


def language_of_project() -> str | None:
    """Return the language of the project around the working folder; None if it chooses none.

    What is wrong with the file is reported where its other settings are read.
    """
    try:
        file = find(Path.cwd())
        data = b"" if file is None else read_file(file, MAX_BYTES)
        if b"language" not in data:
            return None
        table = parse(data.decode("utf-8", "replace"), "").get("rtgen")
    except (OSError, TomlError):
        return None
    language = table.get("language") if isinstance(table, dict) else None
    return language if language in LANGUAGES else None
