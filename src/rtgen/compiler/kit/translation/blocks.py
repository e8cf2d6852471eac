"""The paragraphs of a page of Markdown, as a catalogue has them."""

from __future__ import annotations

from collections.abc import Iterator

_CODE = "```"


def blocks(page: str) -> Iterator[tuple[str, bool]]:
    """Yield the parts of a page between empty lines, and whether one is text, and no code."""
    inside = False
    lines: list[str] = []
    for line in page.strip().split("\n"):
        if line.lstrip().startswith(_CODE):
            inside = not inside
            if inside and lines:
                yield "\n".join(lines), True
                lines = []
            lines.append(line)
            if not inside:
                yield "\n".join(lines), False
                lines = []
        elif line or inside:
            lines.append(line)
        elif lines:
            yield "\n".join(lines), True
            lines = []
    if lines:
        yield "\n".join(lines), not inside


def paragraphs(page: str) -> Iterator[str]:
    """Yield the paragraphs of text of a page, each on one line."""
    for block, is_text in blocks(page):
        if is_text:
            yield joined(block)


def joined(block: str) -> str:
    """Return a paragraph as one line; the rows of lists and tables stay apart."""
    if block.startswith(("|", "- ", "* ", "1. ")):
        return block
    return " ".join(block.split("\n"))
