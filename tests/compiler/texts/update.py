"""Brings the catalogues of texts to the texts of the sources: python tests/compiler/texts/update.py

Entries whose English text is gone become comments at the end of the file, empty ones are added for
the texts of the rules that a catalogue covers, which are those that the comments of titles name,
the titles of all rules, help and what commands print, and the texts of the page and its server.
"""

from __future__ import annotations

import extraction
from babel.messages.pofile import read_po, write_po

from rtgen.compiler.kit.translation.catalogue import FOLDER, PAGE, SERVER, WORD

CONTEXTS = (SERVER, PAGE, WORD)
WIDTH = 100


def texts(context: str | None) -> frozenset[str]:
    """Return the English texts that entries of a context may have."""
    if context == PAGE:
        return extraction.texts_of_page()
    if context == SERVER:
        return frozenset(extraction.said_by_server())
    if context == WORD:
        return extraction.words_alone()
    written = extraction.written_texts().values()
    return extraction.texts_of_sources().union(beside_rules(), *written)


def beside_rules() -> frozenset[str]:
    """Return the titles of all rules, and what is no diagnostic: help, and what commands print."""
    return frozenset(text for each in extraction.BESIDE_RULES for text in each())


def main() -> None:
    """Update each catalogue, and print how much is to be translated."""
    written = extraction.written_texts()
    said = extraction.said_texts()
    known = {context: texts(context) for context in (None, *CONTEXTS)}
    for file in sorted(FOLDER.rglob("*.po")):
        with file.open("rb") as stream:
            catalogue = read_po(stream)
        codes = {c for m in catalogue for text in m.auto_comments for c in text.split()}
        for message in [m for m in catalogue if m.id and m.id not in known[m.context]]:
            catalogue.delete(message.id, message.context)
            catalogue.obsolete[message.id] = message
        for code in sorted(codes):
            for text in (*written[code], *sorted(said[code])):
                if text not in catalogue:
                    catalogue.add(text)
        for text in sorted(beside_rules()):
            if text not in catalogue:
                catalogue.add(text)
        for context in (SERVER, WORD):
            for text in sorted(known[context]):
                if catalogue.get(text, context) is None:
                    catalogue.add(text, context=context)
        for _, text in extraction.page()["texts"]:
            if catalogue.get(text, PAGE) is None:
                catalogue.add(text, context=PAGE)
        with file.open("wb") as stream:
            write_po(stream, catalogue, width=WIDTH)
        empty = sum(1 for m in catalogue if m.id and not m.string)
        print(f"{file.name}: {empty} to translate, {len(catalogue.obsolete)} obsolete")


if __name__ == "__main__":
    main()
