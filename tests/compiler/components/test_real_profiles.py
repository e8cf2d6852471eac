"""Profiles written by RTCBuilder, and systems by RTSystemEditor, read and written.

`RTGEN_OLD_RTCS` names a folder of repositories with RTCs, as they are: each profile, module and IDL
file goes through `rtgen convert` and `rtgen generate --target openrtm`.
"""

from __future__ import annotations

import os
import re
import shlex
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pytest
from lxml import etree

from rtgen.cli import run
from rtgen.compiler.frontends.kit import located_xml
from rtgen.compiler.frontends.kit.located_xml import Element
from rtgen.compiler.frontends.profiles import profile_yaml, rts_profile

GOLDEN = Path(__file__).parents[4] / "shared" / "golden" / "rtc_profiles"
PROFILES = sorted(GOLDEN.glob("rtc/*.xml"))
SYSTEMS = sorted(GOLDEN.glob("rts/*.xml"))

REPOSITORIES = os.environ.get("RTGEN_OLD_RTCS", "")
WHOLE = [
    pytest.param(path, id=path.name)
    for path in sorted(Path(REPOSITORIES).iterdir() if REPOSITORIES else ())
    if path.is_dir()
]
LOCATED = re.compile(r"^.+?:\d+:\d+: error\[[A-Z]+\d{4}\]: ", re.MULTILINE)
INCLUDED = re.compile(r"the folder of its includes: (-I .+)")

pytestmark = pytest.mark.skipif(
    not PROFILES, reason="no profiles: ../shared/golden/rtc_profiles is missing"
)


def facts(element: Element) -> Any:
    """Return the YAML content of an element; elements of different names in the schema's order."""
    attributes = {
        k: v for k, v in element.attributes.items() if k[0] != profile_yaml.XSI
    }
    by_name: dict[tuple[str, str], list[Any]] = {}
    for child in element.children:
        by_name.setdefault(child.name, []).append(facts(child))
    text = "" if element.children else element.text.strip()
    return element.name, attributes, by_name, text


@pytest.mark.sampled(3)
@pytest.mark.parametrize("path", [*PROFILES, *SYSTEMS], ids=lambda p: p.stem[-40:])
def test_nothing_is_lost(path: Path, capfd: pytest.CaptureFixture[str]) -> None:
    form = "rtc" if path in PROFILES else "rts"
    assert run(["convert", str(path), "--to", f"{form}-xml", "-q"]) == 0
    written = capfd.readouterr().out
    canonical = [
        etree.tostring(etree.fromstring(data), method="c14n", with_comments=True)
        for data in (written.encode(), path.read_bytes())
    ]
    assert canonical[0] == canonical[1]
    tree = located_xml.parse(
        located_xml.decode(path.read_bytes(), path.name), path.name
    )
    again = profile_yaml.to_xml(profile_yaml.to_yaml(tree), path.name)
    assert facts(located_xml.parse(again, path.name)) == facts(tree)


@pytest.mark.parametrize("path", SYSTEMS, ids=lambda p: p.stem[-40:])
def test_a_system_is_the_same_in_yaml(path: Path) -> None:
    xml = rts_profile.load(path)
    tree = located_xml.parse(xml.sources[path.as_posix()], path.name)
    data = profile_yaml.to_yaml(tree).encode()
    yaml = rts_profile.load_bytes(data, "system.yaml")
    assert (yaml.system is None) == (xml.system is None)
    if xml.system is not None and yaml.system is not None:
        for name in ("id", "abstract", "activation", "properties"):
            assert getattr(yaml.system, name) == getattr(xml.system, name)
        pairs = zip(yaml.system.components, xml.system.components, strict=True)
        for one, other in pairs:
            assert (one.instance, one.id, one.rate) == (
                other.instance,
                other.id,
                other.rate,
            )
            assert one.configuration == other.configuration


def rtcs(repository: Path) -> Iterator[Path]:
    """Yield the profiles of RTCs, the modules that register one, and the IDL files of a folder."""
    marks = {".xml": b":RtcProfile", ".py": b"registerFactory(", ".idl": b""}
    for path in sorted(repository.rglob("*")):
        mark = marks.get(path.suffix.lower())
        if mark is not None and path.is_file() and mark in path.read_bytes():
            yield path


@pytest.mark.nightly
@pytest.mark.parametrize(
    "repository",
    [
        pytest.param(GOLDEN / "rtc", id="profiles alone"),
        *(WHOLE or [pytest.param(None, id="RTGEN_OLD_RTCS")]),
    ],
)
def test_old_repositories(
    repository: Path | None,
    tmp_path: Path,
    monkeypatch: pytest.MonkeyPatch,
    capfd: pytest.CaptureFixture[str],
) -> None:
    """Python compiles that is generated; what is refused has a place, a code and a hint."""
    if repository is None:
        pytest.skip("RTGEN_OLD_RTCS names no folder of repositories with RTCs")

    def succeeds(*words: str) -> tuple[bool, str]:
        code = run(list(words))
        out, err = capfd.readouterr()
        assert code in (0, 2), err
        if code:
            assert LOCATED.search(err), err
            assert "hint: " in err, err
        return code == 0, out + err

    for number, path in enumerate(rtcs(repository.resolve())):
        folder = tmp_path / str(number)
        folder.mkdir()
        monkeypatch.chdir(folder)
        sources, included = [str(path)], ["-I", str(path.parent)]
        if path.suffix.lower() != ".idl":
            is_converted, told = succeeds("convert", str(path), "-o", ".")
            *_, words = ("", *INCLUDED.findall(told))
            included = shlex.split(words)
            if path.suffix.lower() == ".py":
                sources = [str(p) for p in folder.glob("*.idl")]
                assert sources or not is_converted
        for source in sources:
            if succeeds("generate", source, *included, "--target", "openrtm")[0]:
                for module in folder.rglob("*.py"):
                    compile(module.read_bytes(), module.name, "exec")
