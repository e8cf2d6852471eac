"""The npm packages in the built page of `rtgen ui`, which are a part of rtgen's wheel.

    python requirements/page.py BILL

completes the bill of materials (CycloneDX JSON) of an environment by them and by rtgen's version,
and validates it.
"""

from __future__ import annotations

import json
import re
import sys
from pathlib import Path
from typing import Any, NamedTuple
from urllib.parse import quote

ROOT = Path(__file__).resolve().parent.parent
LICENSES = ROOT / "src/rtgen/ui/page/licenses.md"
"""The licences of the packages, which vite writes when it builds the page."""

_PACKAGE = re.compile(r"^## (\S+) - (\S+) \((.+)\)$", re.MULTILINE)


class Package(NamedTuple):
    """A package with its SPDX expression."""

    name: str
    version: str
    licence: str

    @property
    def url(self) -> str:
        """The package URL."""
        return f"pkg:npm/{quote(self.name)}@{self.version}"


def packages() -> list[Package]:
    """Return the packages in the built page. Raises FileNotFoundError without a page."""
    text = LICENSES.read_text("utf-8")
    return [Package(*found) for found in _PACKAGE.findall(text)]


def complete(bill: dict[str, Any], version: str, found: list[Package]) -> None:
    """Add the version of rtgen, and the packages with rtgen's dependency on them."""
    root = bill["metadata"]["component"]
    root["version"] = version
    bill["components"] += (
        {
            "bom-ref": package.url,
            "licenses": [
                {"acknowledgement": "declared", "expression": package.licence}
            ],
            "name": package.name,
            "purl": package.url,
            "type": "library",
            "version": package.version,
        }
        for package in found
    )
    [edges] = (d for d in bill["dependencies"] if d["ref"] == root["bom-ref"])
    edges["dependsOn"] = sorted({*edges.get("dependsOn", ()), *(p.url for p in found)})
    bill["dependencies"] += ({"ref": package.url} for package in found)


def main() -> None:
    """Complete the bill of materials that is the argument."""
    from cyclonedx.schema import SchemaVersion
    from cyclonedx.validation.json import JsonStrictValidator

    sys.path.insert(0, str(ROOT / "src"))
    from rtgen.facts.version import __version__

    file = Path(sys.argv[1])
    bill = json.loads(file.read_text("utf-8"))
    complete(bill, __version__, packages())
    text = json.dumps(bill, indent=2, sort_keys=True) + "\n"
    schema = SchemaVersion.from_version(bill["specVersion"])
    if error := JsonStrictValidator(schema).validate_str(text):
        sys.exit(f"{file}: {error}")
    file.write_text(text, "utf-8")


if __name__ == "__main__":
    main()
