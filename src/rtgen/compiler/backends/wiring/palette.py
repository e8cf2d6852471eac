"""Colours of wiring diagrams, for light and dark backgrounds.

Text has a contrast of at least 4.5:1 to its background (WCAG 2.1, 1.4.3).
"""

from __future__ import annotations

from colorsys import hls_to_rgb
from dataclasses import dataclass

_CONTRAST = 4.6
_GOLDEN = 0.618033988749895
"""Multiples of the golden section's share of the circle are far from each other."""


@dataclass(frozen=True, slots=True)
class Scheme:
    """Colours as #rrggbb; `links` are assigned to types in the order of their first connection."""

    page: str
    box: str
    border: str
    rule: str
    text: str
    muted: str
    links: tuple[str, ...]

    def more(self, count: int) -> tuple[str, ...]:
        """Return the first `count` colours of links, with further hues if there are not as many."""
        ways = list(self.links)
        number = 0
        while len(ways) < count:
            colour = self._hue(number)
            if colour not in ways:
                ways.append(colour)
            number += 1
        return tuple(ways[:count])

    def _hue(self, number: int) -> str:
        """Return a colour of another hue than those before it, with the contrast of text."""
        hue = number * _GOLDEN % 1
        dark = luminance(self.page) < 0.5
        ground = luminance(self.box if dark else self.page)
        steps = (
            range(20 + number % 3 * 5, 100)
            if dark
            else range(60 - number % 3 * 8, 0, -1)
        )
        for step in steps:
            parts = hls_to_rgb(hue, step / 100, 0.85 if number % 2 else 0.5)
            colour = "#" + "".join(f"{round(part * 255):02x}" for part in parts)
            high, low = sorted((luminance(colour), ground), reverse=True)
            if (high + 0.05) / (low + 0.05) >= _CONTRAST:
                return colour
        raise AssertionError(hue)


def luminance(colour: str) -> float:
    """Return the relative luminance (WCAG 2.1) of #rrggbb."""
    shares = [int(colour[place : place + 2], 16) / 255 for place in (1, 3, 5)]
    red, green, blue = (
        share / 12.92 if share <= 0.04045 else ((share + 0.055) / 1.055) ** 2.4
        for share in shares
    )
    return 0.2126 * red + 0.7152 * green + 0.0722 * blue


LIGHT = Scheme(
    page="#fbfcfd",
    box="#ffffff",
    border="#52606d",
    rule="#cbd2d9",
    text="#1f2933",
    muted="#52606d",
    links=(
        *("#1f6fb4", "#b4500f", "#237047", "#8e44ad", "#c0392b", "#0b7474"),
        *("#806000", "#b03a78", "#a0119c", "#556f1a"),
    ),
)

DARK = Scheme(
    page="#0d1117",
    box="#161b22",
    border="#8b949e",
    rule="#30363d",
    text="#e6edf3",
    muted="#9da7b1",
    links=(
        *("#6cb6ff", "#f69d50", "#57c98a", "#d2a8ff", "#ff8f83", "#4fd1c5"),
        *("#e3b341", "#f59ac6", "#8b9bff", "#a8c957"),
    ),
)
