"""Cases `rtc_profile/*.xml`: the component in IDL (`.idl`) and the findings (`.txt`)."""

from __future__ import annotations

from pathlib import Path

import pytest
from msgspec.structs import replace

from rtgen.cli import run
from rtgen.compiler.backends.kit.idl_text import idl_text
from rtgen.compiler.diagnostics import Diagnostic, has_errors, in_order
from rtgen.compiler.frontends import idl
from rtgen.compiler.frontends.profiles import rtc_profile
from rtgen.compiler.lowering.profiles.lower import lower
from rtgen.compiler.lowering.settings import Settings
from rtgen.compiler.typemap.profiles import rules

CASES = Path(__file__).parent / "rtc_profile"
SPECS = Path(__file__).parents[2] / "specs" / "idl"


def read(path: Path) -> tuple[str, list[Diagnostic]]:
    """Return the component as IDL, and the findings."""
    known = [SPECS / "BasicDataType.idl", CASES / "base" / "Taken.idl"]
    base = idl.load(known, root=SPECS).model
    given = frozenset(file.as_posix() for file in known)
    result = rtc_profile.load([path], root=CASES, include=())
    model = replace(
        base,
        files=(*base.files, *result.model.files),
        profiles=result.model.profiles,
    )
    lowered = lower(model, Settings(definitions=given))
    made = [d for d in lowered.model.declarations if d not in base.declarations]
    text = idl_text(lowered.model, made, components=True)
    return text, in_order((*result.diagnostics, *lowered.diagnostics))


def shown(found: list[Diagnostic]) -> str:
    lines = []
    for diagnostic in found:
        assert diagnostic.span is not None
        place = f"{diagnostic.span.line}:{diagnostic.span.column}"
        lines.append(
            f"{place}: {diagnostic.severity} {diagnostic.code}: {diagnostic.message}\n"
        )
        lines += [f"  hint: {diagnostic.hint}\n"] if diagnostic.hint else []
    return "".join(lines)


@pytest.mark.parametrize("name", sorted(path.stem for path in CASES.glob("*.xml")))
def test_case(name: str, update_golden: bool) -> None:
    text, found = read(CASES / f"{name}.xml")
    written = {".idl": text, ".txt": shown(found)}
    for suffix, content in written.items():
        file = CASES / f"{name}{suffix}"
        if update_golden:
            file.write_text(content, encoding="utf-8", newline="")
        assert content == file.read_bytes().decode()
    if name.startswith("RTC"):
        assert name in {diagnostic.code for diagnostic in found}


def test_every_rule_has_a_case() -> None:
    assert {rule.code for rule in rules.RULES} <= {p.stem for p in CASES.glob("*.xml")}


@pytest.mark.parametrize(
    "name", ["everything", "old_template", "RTC0537", "events", "names"]
)
def test_the_idl_is_read_again(name: str, tmp_path: Path) -> None:
    text, _ = read(CASES / f"{name}.xml")
    file = tmp_path / "Component.idl"
    file.write_text(f'#include "BasicDataType.idl"\n{text}', encoding="utf-8")
    again = idl.load([file], root=tmp_path, include=[SPECS])
    assert not has_errors(again.diagnostics), again.diagnostics


@pytest.mark.sampled(3)
@pytest.mark.parametrize(
    ("name", "text", "code"),
    [
        ("large.xml", "<a>" + "x" * (16 * 1024 * 1024), "RTC0505"),
        ("deep.xml", "<a>" * 1000, "RTC0504"),
        ("entity.xml", '<!DOCTYPE a [<!ENTITY b "b">]><a>&b;</a>', "RTC0502"),
        ("zero.xml", "<a>\0</a>", "RTC0501"),
        ("large.yaml", "rtcProfile:\n" + "  a: b\n" * 200_000, "RTC0545"),
        ("deep.yaml", "rtcProfile: " + "[" * 20_000, "RTC0545"),
        ("alias.yaml", "rtcProfile: {a: &a [x], b: [*a, *a]}", "RTC0545"),
        ("python.yaml", 'rtcProfile: !!python/object/apply:os.getcwd ["x"]', "RTC0545"),
    ],
)
def test_no_file_harms(name: str, text: str, code: str, tmp_path: Path) -> None:
    path = tmp_path / name
    path.write_text(text, encoding="utf-8")
    found = rtc_profile.load([path], root=tmp_path, include=())
    assert not found.model.profiles
    assert [each.code for each in found.diagnostics] == [code]


@pytest.mark.parametrize(
    "encoding", ["shift_jis", "euc_jp", "utf-16", "utf-8-sig", "windows-31j"]
)
def test_encodings(
    encoding: str, tmp_path: Path, capfdbinary: pytest.CaptureFixture[bytes]
) -> None:
    """A profile in another encoding is read, and written with that encoding."""
    text = (CASES / "everything.xml").read_text(encoding="utf-8")
    declared = encoding.removesuffix("-sig")
    text = text.replace("UTF-8", declared, 1).replace('"Lab"', '"産総研"')
    data = text.encode(
        {"windows-31j": "cp932"}.get(encoding, encoding), "xmlcharrefreplace"
    )
    path = tmp_path / "RTC.xml"
    path.write_bytes(data)
    found = rtc_profile.load([path], root=tmp_path, include=())
    assert [each.vendor for each in found.model.profiles] == ["産総研"]
    assert run(["convert", str(path), "--to", "rtc-xml", "-q"]) == 0
    assert capfdbinary.readouterr().out == data
