"""Catalogues of gettext: `locale/<language>/LC_MESSAGES/rtgen.mo`, made of the .po beside it.

The texts are templates with the insertions `{0}`, `{1}`, in the order of the English text. Messages
have their values already, so these are found again between the constant parts of the template.
Texts of the page of `rtgen ui` have the context PAGE, and insertions by name, which it fills in.
"""

from __future__ import annotations

import gettext
import re
from collections.abc import Mapping
from functools import cache
from itertools import pairwise
from pathlib import Path
from string import Formatter
from typing import NamedTuple, TypeAlias

FOLDER = Path(__file__).resolve().parents[3] / "locale"
DOMAIN = "rtgen"
PAGE = "page"
"""The context of the texts of the page of `rtgen ui`."""
SERVER = "server"
"""The context of what its server says to pages: names of edits, such as `move {0}`, are short."""
WORD = "word"
"""The context of words that stand alone; in texts, `state` is a name of a definition."""
_CONTEXT = "\4"
"""Between a context and its text in a compiled catalogue."""
_PLACE = ["", " (in [", "])"]
"""The constant parts of a text with the section that it is about."""
_MAX_DEPTH = 4
"""Insertions that are messages themselves, such as reasons, are translated up to this depth."""
_MOST_TEXT = 8000
_QUOTE = "'"
_QUOTES = ("'", '"', "`")
_JOINT = "\ue000"
"""Around insertions, while they are put into a text."""
_OF_JAPANESE = "[\u3041-\u30ff\u4e00-\u9fff]"
_JOINTS = re.compile(f"(?<={_OF_JAPANESE}) ?{_JOINT} ?(?={_OF_JAPANESE})|{_JOINT}")
_SAID_OF = re.compile(
    r"(?P<subject>'[^']*'|\"[^\"]*\"|\[[^]]*\]|(?!\{')\S+) (?P<what>\S+ .+)", re.DOTALL
)
"""A value, and what is said of it, which is a text of its own."""
_FEW = 16
"""Templates with fewer characters, such as `{0} is {1}`, are in many texts of another meaning."""
_PROSE = re.compile(
    r"\b[a-z]{2,} [a-z]{2,}\b"
    r"|\b(?:the|not|is|are|its?|which|this|that|them)\b"
    r"|(?:^| )(?:a|an|of|out|and|has|with) | (?:a|an|of|out|and|has|with|too)$"
)
_ADDITION = re.compile(r"[;:] | \(|, which ")
_QUOTED = re.compile(r"'[^']*'|`[^`]*`|\"[^\"]*\"")


class Template:
    """The constant parts of a text with insertions; `size` is the number of their characters.

    A template `joins` texts if it has no letters itself, such as `{0}: {1}`; it `divides` them if
    it has such a mark, and `heads` the only one, such as `Error: {0}`. A name that is `quoted` is
    the same in all languages.
    """

    __slots__ = ("divides", "heads", "joins", "parts", "quoted", "size")

    def __init__(self, text: str) -> None:
        self.parts = constant_parts(text)
        self.size = sum(map(len, self.parts))
        self.quoted = [
            before[-1:] == after[:1] and after[:1] in _QUOTES
            for before, after in pairwise(self.parts)
        ]
        self.joins = not any(map(str.isalpha, "".join(self.parts)))
        self.heads = self.parts[1:] == [""] and self.parts[0].endswith(": ")
        self.divides = any(map(_ADDITION.search, self.parts))

    def values(self, text: str) -> list[str] | None:
        """Return what is inserted in `text`; None if it is not made from this template."""
        first, *inner, last = self.parts
        end = len(text) - len(last)
        if end < len(first) or not text.startswith(first) or not text.endswith(last):
            return None
        values = []
        start = len(first)
        for number, part in enumerate(inner):
            if part:
                found = _place_of(part, text, start, end)
            else:
                found = _seam(text, start, end, next(filter(None, inner[number:]), ""))
            if found < 0:
                return None
            values.append(text[start:found])
            start = found + len(part)
        return [*values, text[start:end]]


def _place_of(part: str, text: str, start: int, end: int) -> int:
    """Return the place of a constant part after an insertion that begins at `start`, or -1.

    It is the first one that is outside of quotes of the insertion, else the first one; it is not
    within braces, which are around the value of a struct.
    """
    first, found = -1, text.find(part, start, end)
    quotes = depth = 0
    counted = start
    while found >= 0:
        for number, between in enumerate(text[counted:found].split(_QUOTE)):
            quotes += number > 0
            if quotes % 2 == 0:
                depth += between.count("{") - between.count("}")
        if depth <= 0 or part[0] in _QUOTES:
            if quotes % 2 == 0:
                return found
            first = found if first < 0 else first
        counted = found
        found = text.find(part, found + 1, end)
    return first


def _joined(template: str, values: list[str]) -> str:
    """Return a text with its insertions; spaces that set off names go between Japanese words."""
    return _JOINTS.sub("", template.format(*(f"{_JOINT}{v}{_JOINT}" for v in values)))


def _seam(text: str, start: int, end: int, part: str) -> int:
    """Return where the first of two insertions with nothing between them ends, or -1.

    The second one is an addition, which begins with a mark, or empty. `part` follows the two.
    """
    limit = _place_of(part, text, start, end) if part else end
    seam = _ADDITION.search(text, start, limit) if limit >= 0 else None
    return seam.start() if seam else limit


def constant_parts(template: str) -> list[str]:
    """Return the parts of a template around its insertions: one more than these."""
    parts = [""]
    for constant, field, _, _ in Formatter().parse(template):
        parts[-1] += constant
        if field is not None:
            parts.append("")
    return parts


class Catalogue:
    """The texts of a language."""

    def __init__(self, texts: Mapping[str, str]) -> None:
        self._plain: dict[str, str] = {}
        self._templates: list[tuple[Template, str]] = []
        for english, text in texts.items():
            template = Template(english)
            if len(template.parts) == 1:
                self._plain[template.parts[0]] = text.format()
            elif template.size:
                self._templates.append((template, text))
        # What says a place behind a text comes first; of equal size, `{0}; {1}` comes before
        # `{0}: {1}`, which is a part of it.
        self._templates.sort(
            key=lambda each: (
                each[0].parts != _PLACE,
                -each[0].size,
                ": " in each[0].parts,
            )
        )
        self._by_ends: dict[tuple[str, str], list[tuple[Template, str]]] = {}
        self._ends = [
            {template.parts[end][end:][:1] for template, _ in self._templates}
            for end in (0, -1)
        ]

    def paragraph(self, text: str) -> str:
        """Return a text without insertions in this language; unchanged if it is not there whole."""
        return self._plain.get(text, text)

    def translated(self, text: str) -> str:
        """Return a text in this language; unchanged if it is made from no template."""
        found = self._translated(text, _MAX_DEPTH, {})
        return text if found is None else found.text

    def _translated(self, text: str, depth: int, known: _Known) -> _Translation | None:
        """Return the translation of a text; `known` are those of its parts, by their depth."""
        if (text, depth) not in known:
            known[text, depth] = self._made(text, depth, known)
        return known[text, depth]

    def _made(self, text: str, depth: int, known: _Known) -> _Translation | None:
        plain = self._plain.get(text)
        if plain is not None:
            return _Translation(plain, len(text))
        if depth == 0 or not 1 < len(text) <= _MOST_TEXT:
            return None
        best = self._said_of(text)
        for template, translation in self._candidates(text):
            values = template.values(text)
            if values is None:
                continue
            made = self._filled(template, translation, values, depth - 1, known)
            if made is not None and (best is None or made.rank > best.rank):
                best = made
        if (best is None or not best.is_whole) and (said := _SAID_OF.fullmatch(text)):
            what = self._translated(said["what"], depth - 1, known)
            if what is not None and (what.is_whole or said["subject"][0] == _QUOTE):
                return what._replace(text=f"{said['subject']} {what.text}")
        return best

    def _said_of(self, text: str) -> _Translation | None:
        """Return the translation of what is said of a value, if the catalogue has that."""
        said = _SAID_OF.fullmatch(text)
        what = None if said is None else self._plain.get(said["what"])
        if said is None or what is None:
            return None
        return _Translation(f"{said['subject']} {what}", len(said["what"]))

    def _filled(
        self,
        template: Template,
        translation: str,
        values: list[str],
        depth: int,
        known: _Known,
    ) -> _Translation | None:
        """Return a translation with its insertions; None if it would not be understood."""
        inner = [
            None if quoted and " " not in value else self._whole(value, depth, known)
            for value, quoted in zip(values, template.quoted, strict=True)
        ]
        english = [
            each is None and not quoted and _is_prose(value)
            for each, value, quoted in zip(inner, values, template.quoted, strict=True)
        ]
        tells = template.heads or template.size >= _FEW
        if template.joins:
            tells = any(inner)
        if any(english) and not tells:
            return None
        shown = [
            value if each is None else each.text
            for value, each in zip(values, inner, strict=True)
        ]
        size = template.size + sum(each.size for each in inner if each is not None)
        text = _joined(translation, shown)
        return _Translation(text, size, not any(english), template.divides)

    def _candidates(self, text: str) -> list[tuple[Template, str]]:
        """Return the templates that begin and end with an insertion, or as a text does."""
        first, last = (
            text[end] if text[end] in known else ""
            for end, known in zip((0, -1), self._ends, strict=True)
        )
        if (first, last) not in self._by_ends:
            self._by_ends[first, last] = [
                each
                for each in self._templates
                if each[0].parts[0][:1] in ("", first)
                and each[0].parts[-1][-1:] in ("", last)
            ]
        return self._by_ends[first, last]

    def _whole(self, text: str, depth: int, known: _Known) -> _Translation | None:
        """Return the translation of an insertion; half of one would not be understood."""
        found = self._translated(text, depth, known)
        return found if found is not None and found.is_whole else None


class _Translation(NamedTuple):
    """A text; not `is_whole` with insertions that are sentences and not translated.

    `size` is the number of the English characters that are not values; `divided`: between clauses.
    """

    text: str
    size: int
    is_whole: bool = True
    divided: bool = False

    @property
    def rank(self) -> tuple[bool, int, bool]:
        """The better of two translations has the greater one."""
        return self.is_whole, self.size, self.divided


_Known: TypeAlias = dict[tuple[str, int], _Translation | None]


def _is_prose(text: str) -> bool:
    """Return whether an insertion is a sentence that was not translated."""
    return len(text) > 1 and _PROSE.search(_QUOTED.sub("", text)) is not None


class _Entries(gettext.GNUTranslations):
    """A catalogue of gettext that tells all its texts, to find those with insertions."""

    _catalog: Mapping[object, str]

    def texts(self, context: str = "") -> dict[str, str]:
        """Return the translations of a context by their English texts."""
        found = {}
        for key, text in self._catalog.items():
            if isinstance(key, str) and key:
                before, mark, english = key.rpartition(_CONTEXT)
                if before == context and bool(mark) == bool(context):
                    found[english] = text
        return found


@cache
def catalogue(language: str, context: str = "") -> Catalogue:
    """Return the catalogue of a language, with the texts of a context beside those of none.

    It is empty if it is not installed.
    """
    return Catalogue({**_texts(language), **_texts(language, context)})


def texts_of_page(language: str) -> dict[str, str]:
    """Return the texts of the page in a language by the English ones; none for English."""
    return _texts(language, PAGE)


def _texts(language: str, context: str = "") -> dict[str, str]:
    try:
        entries = gettext.translation(DOMAIN, FOLDER, [language], class_=_Entries)
    except FileNotFoundError:
        return {}
    assert isinstance(entries, _Entries)
    return entries.texts(context)
