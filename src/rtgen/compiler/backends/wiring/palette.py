"""Colours of wiring diagrams, for light and dark backgrounds.

Text has a contrast of at least 4.5:1 to its background (WCAG 2.1, 1.4.3).
"""

from __future__ import annotations

from dataclasses import dataclass


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


LIGHT = Scheme(
    page="#fbfcfd",
    box="#ffffff",
    border="#52606d",
    rule="#cbd2d9",
    text="#1f2933",
    muted="#52606d",
    links=(
        "#1f6fb4",
        "#b4500f",
        "#237047",
        "#8e44ad",
        "#c0392b",
        "#0b7474",
        "#806000",
        "#b03a78",
        "#4f5d75",
        "#556f1a",
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
        "#6cb6ff",
        "#f69d50",
        "#57c98a",
        "#d2a8ff",
        "#ff8f83",
        "#4fd1c5",
        "#e3b341",
        "#f59ac6",
        "#a9b8cf",
        "#a8c957",
    ),
)
