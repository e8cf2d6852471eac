"""The form of help texts: lines with full-width characters fit the terminal."""

from __future__ import annotations

from collections.abc import Iterable

import click

from rtgen.facts.columns import columns, padded, wrapped


class Formatter(click.HelpFormatter):
    """A formatter of click that counts columns, and breaks texts without spaces between words."""

    def write_text(self, text: str) -> None:
        if text.isascii():
            super().write_text(text)
            return
        indent = " " * self.current_indent
        width = self.width - self.current_indent
        paragraphs = (
            "\n".join(indent + line for line in wrapped(part, width))
            for part in text.split("\n\n")
        )
        self.write("\n\n".join(paragraphs) + "\n")

    def write_dl(
        self,
        rows: Iterable[tuple[str, str]],
        col_max: int = 30,
        col_spacing: int = 2,
    ) -> None:
        rows = [*rows]
        if all(text.isascii() for row in rows for text in row):
            super().write_dl(rows, col_max, col_spacing)
            return
        widest = max(columns(term) for term, _ in rows)
        first = min(widest, col_max) + col_spacing
        indent = " " * self.current_indent
        for term, text in rows:
            lines = wrapped(text, max(self.width - self.current_indent - first, 10))
            if lines and columns(term) <= first - col_spacing:
                self.write(f"{indent}{padded(term, first)}{lines.pop(0)}\n")
            else:
                self.write(f"{indent}{term}\n")
            for line in lines:
                self.write(f"{indent}{'':{first}}{line}\n")


class Context(click.Context):
    """A context of click whose help has this form."""

    formatter_class = Formatter
