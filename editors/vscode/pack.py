"""Packs the extension: python pack.py FILE.vsix

A .vsix is a zip with a manifest beside the files of the extension. The same files give the same
octets; modules that `npm install` has fetched are packed with them.
"""

from __future__ import annotations

import json
import sys
from pathlib import Path
from xml.sax.saxutils import quoteattr
from zipfile import ZIP_DEFLATED, ZipFile, ZipInfo

FOLDER = Path(__file__).resolve().parent
_LEFT_OUT = {"pack.py", "package-lock.json", ".gitignore"}
_DATE = (1980, 1, 1, 0, 0, 0)
_TYPES = """<?xml version="1.0" encoding="utf-8"?>
<Types xmlns="http://schemas.openxmlformats.org/package/2006/content-types">
  <Default Extension="json" ContentType="application/json"/>
  <Default Extension="js" ContentType="application/javascript"/>
  <Default Extension="md" ContentType="text/markdown"/>
  <Default Extension="txt" ContentType="text/plain"/>
  <Default Extension="vsixmanifest" ContentType="text/xml"/>
</Types>
"""
_MANIFEST = """<?xml version="1.0" encoding="utf-8"?>
<PackageManifest Version="2.0.0" xmlns="http://schemas.microsoft.com/developer/vsx-schema/2011">
  <Metadata>
    <Identity Language="en-US" Id={name} Version={version} Publisher={publisher}/>
    <DisplayName>{title}</DisplayName>
    <Description xml:space="preserve">{description}</Description>
    <Categories>{categories}</Categories>
    <Properties>
      <Property Id="Microsoft.VisualStudio.Code.Engine" Value={engine}/>
    </Properties>
  </Metadata>
  <Installation>
    <InstallationTarget Id="Microsoft.VisualStudio.Code"/>
  </Installation>
  <Dependencies/>
  <Assets>
    <Asset Type="Microsoft.VisualStudio.Code.Manifest" Path="extension/package.json"
      Addressable="true"/>
    <Asset Type="Microsoft.VisualStudio.Services.Content.Details" Path="extension/README.md"
      Addressable="true"/>
  </Assets>
</PackageManifest>
"""


def manifest(package: dict[str, object]) -> str:
    """The manifest of the package that package.json describes."""
    engines = package["engines"]
    categories = package["categories"]
    assert isinstance(engines, dict)
    assert isinstance(categories, list)
    return _MANIFEST.format(
        name=quoteattr(str(package["name"])),
        version=quoteattr(str(package["version"])),
        publisher=quoteattr(str(package["publisher"])),
        title=package["displayName"],
        description=package["description"],
        categories=",".join(map(str, categories)),
        engine=quoteattr(str(engines["vscode"])),
    )


def files() -> list[Path]:
    """The files of the extension, in order."""
    found = (path for path in FOLDER.rglob("*") if path.is_file())
    return sorted(
        path
        for path in found
        if path.name not in _LEFT_OUT
        and path.suffix not in (".vsix", ".pyc")
        and "__pycache__" not in path.parts
    )


def pack(target: Path) -> None:
    """Write the package."""
    package = json.loads((FOLDER / "package.json").read_text(encoding="utf-8"))
    contents = {
        "[Content_Types].xml": _TYPES.encode(),
        "extension.vsixmanifest": manifest(package).encode(),
        **{
            f"extension/{path.relative_to(FOLDER).as_posix()}": path.read_bytes()
            for path in files()
        },
    }
    with ZipFile(target, "w", ZIP_DEFLATED) as archive:
        for name, data in contents.items():
            entry = ZipInfo(name, _DATE)
            entry.compress_type = ZIP_DEFLATED
            archive.writestr(entry, data)


if __name__ == "__main__":
    pack(Path(sys.argv[1]))
