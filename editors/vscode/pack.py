"""Packs the extension, after `npm install` and `npm run bundle`.

A .vsix is a zip with a manifest beside the files of the extension. The bundle has the code of the
modules; their licences are packed as one file. The same files give the same octets.
"""

from __future__ import annotations

import argparse
import json
from pathlib import Path
from xml.sax.saxutils import quoteattr
from zipfile import ZIP_DEFLATED, ZipFile, ZipInfo

FOLDER = Path(__file__).resolve().parent
_PACKED = (
    *("package.json", "README.md", "icon.png", "dist/extension.js"),
    *("*-configuration.json", "syntaxes/*.json", "snippets/*.json"),
)
_LICENCE = FOLDER.parents[1] / "LICENSE"
_DATE = (1980, 1, 1, 0, 0, 0)
_TYPES = """<?xml version="1.0" encoding="utf-8"?>
<Types xmlns="http://schemas.openxmlformats.org/package/2006/content-types">
  <Default Extension="json" ContentType="application/json"/>
  <Default Extension="js" ContentType="application/javascript"/>
  <Default Extension="md" ContentType="text/markdown"/>
  <Default Extension="png" ContentType="image/png"/>
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
    <Asset Type="Microsoft.VisualStudio.Services.Icons.Default" Path="extension/icon.png"
      Addressable="true"/>
    <Asset Type="Microsoft.VisualStudio.Services.Content.License"
      Path="extension/LICENSE.txt" Addressable="true"/>
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


def files(folder: Path) -> list[Path]:
    """The files of the extension in a folder, in order."""
    return sorted(path for pattern in _PACKED for path in folder.glob(pattern))


def licences(folder: Path) -> str:
    """The licences of the modules that the bundle contains."""
    modules = json.loads((folder / "package-lock.json").read_text("utf-8"))["packages"]
    texts = []
    for place, module in sorted(modules.items()):
        if not place or module.get("dev"):
            continue
        names = sorted((folder / place).glob("[Ll][Ii][Cc][Ee][Nn][CcSs][Ee]*"))
        text = names[0].read_text("utf-8") if names else module.get("license", "")
        texts.append(
            f"{place.rpartition('node_modules/')[2]} {module['version']}\n\n{text}"
        )
    return "\n\n".join(texts)


def pack(target: Path, folder: Path = FOLDER) -> None:
    """Write the package of the extension in a folder.

    Raises FileNotFoundError if the bundle has not been made.
    """
    if not (folder / "dist" / "extension.js").is_file():
        raise FileNotFoundError(
            "dist/extension.js is missing: npm install, npm run bundle"
        )
    package = json.loads((folder / "package.json").read_text(encoding="utf-8"))
    contents = {
        "[Content_Types].xml": _TYPES.encode(),
        "extension.vsixmanifest": manifest(package).encode(),
        "extension/LICENSE.txt": _LICENCE.read_bytes(),
        "extension/LICENSES-of-modules.txt": licences(folder).encode(),
        **{
            f"extension/{path.relative_to(folder).as_posix()}": path.read_bytes()
            for path in files(folder)
        },
    }
    with ZipFile(target, "w", ZIP_DEFLATED) as archive:
        for name, data in contents.items():
            entry = ZipInfo(name, _DATE)
            entry.compress_type = ZIP_DEFLATED
            archive.writestr(entry, data)


def main() -> None:
    """Pack the file that the command line names."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("target", metavar="FILE.vsix", type=Path)
    target = parser.parse_args().target
    if target.suffix != ".vsix":
        parser.error(f"{target}: a package ends in .vsix")
    try:
        pack(target)
    except FileNotFoundError as error:
        parser.error(str(error))


if __name__ == "__main__":
    main()
