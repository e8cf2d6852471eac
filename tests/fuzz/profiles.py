"""Fuzzing of profiles: any file gives findings, or a component that can be generated."""

from __future__ import annotations

import re
from collections.abc import Iterable, Iterator
from functools import cache
from pathlib import Path
from random import Random

from fuzzing import ViolationError, log_uniform
from msgspec.structs import replace

from rtgen.compiler.backends import Options
from rtgen.compiler.backends.components.checks import check, components_of
from rtgen.compiler.backends.profiles.rtc_profile import profile_text
from rtgen.compiler.diagnostics import Diagnostic, InputError, has_errors
from rtgen.compiler.diagnostics.report import report
from rtgen.compiler.frontends import idl
from rtgen.compiler.frontends.kit import character_rules, located_xml, xml_rules
from rtgen.compiler.frontends.profiles import (
    profile_yaml,
    rtc_profile,
    rts_profile,
    rules,
)
from rtgen.compiler.inspection.models import inspect
from rtgen.compiler.lowering.profiles.lower import lower
from rtgen.compiler.lowering.settings import Settings
from rtgen.compiler.lowering.stage import Lowered
from rtgen.compiler.model import Model
from rtgen.compiler.typemap.profiles.rules import RULES

ROOT = Path(__file__).parents[2]
CASES = ROOT / "tests/golden"

_CODES = {
    r.code for r in (*RULES, *xml_rules.RULES, *rules.RULES, *character_rules.RULES)
}
_OPTIONS = Options(package="fuzzed", skeleton_package="", version="0")
_MAX_CHARACTERS = 200_000
_ATTRIBUTE = re.compile(r'([\w.-]+(?::[\w.-]+)?)\s*=\s*"([^"]*)"')
_TAG = re.compile(r"<[^<>]*>")
_ELEMENT = re.compile(r"<[^<>]*/>")
_VALUES = """
    0 1 -1 1.0 1e3 1e999 nan inf -0 0x10 010 1_0 \u0661 99999999999999999999999999 true YES %s {0}
    a,b 1,2,3 , () (a) (a,b) x<1 0<=x<=1 1<=x<=0 {k:x<1} x text slider slider. slider.0.1 spin radio
    checkbox orderd_list int double bool string std::string std::vector&lt;int&gt; vector&lt;&gt;
    std::vector&lt;std::vector&lt;int&gt;&gt; unsigned&#32;int char RTC::TimedLong TimedLong ::
    RTC::TimedLong::data RTC::Time IDL:RTC/TimedLong:1.0 A::B A::B::C a::b class def import self
    RTC.X DataInPort DataOutPort EventPort Provided Required provided LEFT left 0.1 0.2 0.3 0.4
    PERIODIC EVENT_DRIVEN STATIC 2014-01-01T00:00:00 2014-02-30T00:00:00Z 2014-01-01 &#10; &#9;
    &lt;br/&gt; &#32; é 日本 &amp; &quot; \u2028 \x85 \ufffd rtgen.definition __widget__ {} [] null
""".split()
_VALUES += [
    text.replace('"', "&quot;")
    for text in (
        *('{"type":"octet"}', '{"min":1}', '{"base":"A"}', '{"order":[1]}', '{"a":{}}'),
        *('{"name":"RTC::X"}', '{"annotations":[["rtc"]]}', '{"default":null}'),
        *(
            '{"doc":"*/"}',
            '{"identifier":"a-b"}',
            '{"supports":["A"]}',
            '{"files":["x"]}',
        ),
    )
]
_DOCUMENT_TYPE = (
    '<!DOCTYPE r [<!ENTITY a "aaaaaaaaaa"><!ENTITY b "&a;&a;&a;&a;&a;&a;">'
    '<!ENTITY c "&b;&b;&b;&b;&b;&b;&b;">]>'
)


class ProfileTarget:
    """The golden profiles and those of the reference build, broken and mixed, in XML and YAML."""

    def __init__(self, folder: Path) -> None:
        self._folder = folder

    def make(self, number: int) -> bytes:
        """Return a profile with attributes and elements changed, doubled, exchanged or left out."""
        chance = Random(number)
        text = chance.choice(_texts(number % 5 == 0))
        for _ in range(log_uniform(1, 20, chance.random())):
            text = _changed(chance, text)
        encoding = chance.choice(["utf-8"] * 6 + ["utf-16", "utf-8-sig", "shift_jis"])
        data = text[:_MAX_CHARACTERS].encode(encoding, "xmlcharrefreplace")
        if _is_yaml(number):
            data = _as_yaml(data)
        if chance.random() < 0.1:
            at = chance.randrange(len(data))
            data = data[:at] + chance.randbytes(2) + data[at + chance.randrange(3) :]
        return data

    def check(self, number: int, data: bytes) -> Iterator[str]:
        """Read the profile as a component or a system; generate all output of a component."""
        if number % 5 == 0:
            yield from self._system(data)
            return
        path = self._folder / f"input.{'yaml' if _is_yaml(number) else 'xml'}"
        path.write_bytes(data)
        read = rtc_profile.load([path], root=self._folder, include=())
        base = _base()
        known = replace(
            base,
            files=(*base.files, *read.model.files),
            profiles=read.model.profiles,
        )
        lowered = lower(known, Settings()) if read.model.profiles else Lowered(known)
        model = lowered.model
        diagnostics = (*read.diagnostics, *lowered.diagnostics)
        _hold(diagnostics)
        report(diagnostics, read.sources)
        yield from {d.code for d in diagnostics}
        if has_errors(diagnostics):
            yield "errors"
            return
        inspect(model, diagnostics)
        wrong = [d for d in check(model) if has_errors([d])]
        if wrong:
            raise ViolationError(f"{wrong[0].code}: {wrong[0].message}")
        for component in components_of(model):
            located_xml.parse(profile_text(model, component, _OPTIONS), "RTC.xml")
        yield "read"

    def _system(self, data: bytes) -> Iterator[str]:
        read = rts_profile.load_bytes(data, "system.xml")
        report(read.diagnostics, read.sources)
        yield "system" if read.system is not None else "no system"
        yield from {d.code for d in read.diagnostics}


def _hold(found: Iterable[Diagnostic]) -> None:
    for d in found:
        if d.code not in _CODES:
            raise ViolationError(f"{d.code} is not a finding of a profile")


def _is_yaml(number: int) -> bool:
    """Return whether a case is a profile of a component in YAML."""
    return number % 7 == 0 and number % 5 > 0


def _as_yaml(data: bytes) -> bytes:
    """Return the YAML form of a profile, or the octets themselves if it has none."""
    try:
        tree = located_xml.parse(located_xml.decode(data, "x"), "x")
        return profile_yaml.to_yaml(tree).encode("utf-8", "replace")
    except (InputError, ValueError, KeyError):
        return data


@cache
def _base() -> Model:
    folder = ROOT / "specs/idl"
    return idl.load([folder / "ExtendedDataTypes.idl"], root=folder).model


@cache
def _texts(systems: bool) -> list[str]:
    if systems:
        found = [*CASES.glob("cases/*/input/s.xml"), *ROOT.glob("specs/**/*.xml")]
    else:
        found = [*CASES.glob("rtc_profile/*.xml"), *ROOT.glob("generated/**/RTC.xml")]
    return [path.read_text("utf-8", "replace") for path in sorted(found)]


def _changed(chance: Random, text: str) -> str:
    one, other = _found(chance, _ATTRIBUTE, text), _found(chance, _ATTRIBUTE, text)
    element, second = _found(chance, _ELEMENT, text), _found(chance, _ELEMENT, text)
    if one is None or other is None or element is None or second is None:
        return text + "<"
    match chance.randrange(40):
        case kind if kind < 20:
            return _put(text, one.span(2), chance.choice(_VALUES))
        case kind if kind < 24:
            return _put(text, one.span(), "")
        case kind if kind < 28:
            return _put(text, one.span(2), other[2])
        case kind if kind < 30:
            return _put(text, one.span(1), other[1])
        case kind if kind < 33:
            return _put(text, (element.start(), element.start()), second[0])
        case kind if kind < 36:
            return _put(text, element.span(), "")
        case 36:
            start, end = sorted((element.start(), second.start()))
            return _put(text, (end, end), text[start:end])
        case 37:
            tag = _found(chance, _TAG, text) or element
            return _put(text, tag.span(), "")
    odd = chance.choice([_DOCUMENT_TYPE, "<a>" * 200, "<![CDATA[x]]>", "<?p x?>"])
    return _put(text, (element.start(), element.start()), odd)


def _found(chance: Random, pattern: re.Pattern[str], text: str) -> re.Match[str] | None:
    """Return the first match after a random place, or of the text if there is none after it."""
    return pattern.search(text, chance.randrange(len(text) + 1)) or pattern.search(text)


def _put(text: str, place: tuple[int, int], new: str) -> str:
    return text[: place[0]] + new + text[place[1] :]
