"""Compiles grammars, templates and texts, and adds the reference pipeline, when rtgen is packed."""

from __future__ import annotations

import sys
from io import BytesIO
from pathlib import Path
from typing import Any

from hatchling.builders.hooks.plugin.interface import BuildHookInterface


class WheelHook(BuildHookInterface):  # type: ignore[type-arg]
    """Runs for the wheel only; the sources hold grammars and templates."""

    PLUGIN_NAME = "custom"

    def initialize(self, version: str, build_data: dict[str, Any]) -> None:
        """Write tables and code beside the sources; an installed wheel also has RH3_FILES."""
        if self.target_name == "wheel":
            root = Path(self.root)
            sys.path[:0] = [str(root / "src"), str(root / "runtime" / "src")]
            from rtgen.compiler.backends.kit.rendering import write_code
            from rtgen.compiler.frontends.kit.lalr_tables import write

            write_code()
            for grammar in sorted((root / "grammars").glob("*.lark")):
                write(grammar)
            for catalogue in sorted((root / "src/rtgen/locale").rglob("*.po")):
                _compile(catalogue)
            if version != "editable":
                from rtgen.compiler.kit.resources import RH3_FILES, RH3_FOLDER

                build_data["force_include"] |= {
                    str(root / source): f"rtgen/{RH3_FOLDER}/{name}"
                    for name, source in RH3_FILES.items()
                }


def _compile(catalogue: Path) -> None:
    from babel.messages.mofile import write_mo
    from babel.messages.pofile import read_po

    from rtgen.facts.files import write_atomically

    with catalogue.open("rb") as file:
        texts = read_po(file)
    compiled = BytesIO()
    write_mo(compiled, texts)
    write_atomically(catalogue.with_suffix(".mo"), compiled.getvalue())
