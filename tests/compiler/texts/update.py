"""Brings the catalogues of texts to the texts of the sources: python tests/compiler/texts/update.py

Entries whose English text is gone become comments at the end of the file, empty ones are added for
the texts of the rules that a catalogue covers, which are those that the comments of titles name,
the titles of all rules, help and what commands print, and the texts of the page and its server.
Where the packages of the page are not installed, the entries of the page stay as they are.
"""

from __future__ import annotations

import re
import sys
from collections.abc import Collection

import extraction
from babel.messages.pofile import read_po, write_po

from rtgen.compiler.kit.translation.catalogue import FOLDER, PAGE, SERVER, WORD

CONTEXTS = (SERVER, PAGE, WORD)
_PROSE = re.compile(r"\b[a-z]{2,}\b.*\b[a-z]{2,}\b")
_INSERTION = re.compile(r"{\d+}")
WIDTH = 100


def texts(context: str | None) -> frozenset[str]:
    """Return the English texts that entries of a context other than PAGE may have."""
    if context == SERVER:
        return frozenset(extraction.said_by_server())
    if context == WORD:
        return extraction.words_alone()
    written = extraction.written_texts().values()
    return extraction.texts_of_sources().union(beside_rules(), *written)


def beside_rules() -> frozenset[str]:
    """Return the titles of all rules, and what is no diagnostic: help, and what commands print."""
    return frozenset(text for each in extraction.BESIDE_RULES for text in each())


def texts_of(codes: Collection[str]) -> list[str]:
    """Return the texts of the rules of some codes, and what their callers say in sentences."""
    written, said = extraction.written_texts(), extraction.said_texts()
    texts = []
    for code in sorted(codes):
        sentences = (t for t in said[code] if _PROSE.search(_INSERTION.sub("", t)))
        texts += [*written[code], *sorted(sentences)]
    return texts


def main() -> None:
    """Update each catalogue, and print how much is to be translated."""
    known = {context: texts(context) for context in (None, SERVER, WORD)}
    try:
        of_page = [text for _, text in extraction.page()["texts"]]
        known[PAGE] = frozenset(of_page)
    except LookupError as error:
        print(f"the texts of the page are left alone: {error}", file=sys.stderr)
        of_page = []
    for file in sorted(FOLDER.rglob("*.po")):
        with file.open("rb") as stream:
            catalogue = read_po(stream)
        codes = {c for m in catalogue for text in m.auto_comments for c in text.split()}
        for message in [m for m in catalogue if m.id]:
            if message.id in known.get(message.context, (message.id,)):
                continue
            catalogue.delete(message.id, message.context)
            catalogue.obsolete[message.id] = message
        for text in (*texts_of(codes), *sorted(beside_rules())):
            if text not in catalogue:
                catalogue.add(text)
        for context in (SERVER, WORD):
            for text in sorted(known[context]):
                if catalogue.get(text, context) is None:
                    catalogue.add(text, context=context)
        for text in of_page:
            if catalogue.get(text, PAGE) is None:
                catalogue.add(text, context=PAGE)
        with file.open("wb") as stream:
            write_po(stream, catalogue, width=WIDTH)
        empty = sum(1 for m in catalogue if m.id and not m.string)
        print(f"{file.name}: {empty} to translate, {len(catalogue.obsolete)} obsolete")


if __name__ == "__main__":
    main()
