"""Pages and anchors of all documented items, and links between them."""

from __future__ import annotations

import posixpath
import re
from enum import StrEnum

from rtgen.compiler.backends.kit.quoting.markdown import Markdown, code, link, text
from rtgen.compiler.model import ArrayType, MapType, NamedType, SequenceType, Type

_NOT_IN_PATHS = re.compile(r"[^A-Za-z0-9_-]+")
_MAX_LENGTH = 80


class Kind(StrEnum):
    """Kind of item that a page or section documents; the values are folders."""

    TYPE = "types"
    COMPONENT = "components"
    SIGNATURE = "signatures"
    DEVICE = "devices"
    BUS = "buses"
    SYSTEM = "systems"


class Places:
    """Page and anchor of each item; clashing path names are numbered."""

    def __init__(self) -> None:
        self._places: dict[tuple[Kind, str], tuple[str, str]] = {}
        self._taken: set[str] = set()
        self._numbers: dict[str, int] = {}

    def page(self, kind: Kind, name: str, path: str = "") -> str:
        """Return the path without suffix of an item's page, the same for each call.

        The path is made from `path`, by default the name.
        """
        if (kind, name) not in self._places:
            free = self._free(f"{kind}/{_plain(path or name)}")
            self._places[kind, name] = (free, "")
        return self._places[kind, name][0]

    def section(self, kind: Kind, name: str, page: str) -> str:
        """Return the anchor of an item's section on a page."""
        anchor = self._free(f"{page}#{_plain(name)}").partition("#")[2]
        self._places[kind, name] = (page, anchor)
        return anchor

    def link(
        self, kind: Kind, name: str, here: str, label: object | None = None
    ) -> Markdown:
        """Return a link from the page `here`, or only the name if the item is not documented."""
        shown = code(name) if label is None else text(label)
        place = self._places.get((kind, name))
        if place is None:
            return shown
        return link(self._way(place, here, ".md"), shown)

    def url(self, kind: Kind, name: str, here: str) -> str:
        """Return the relative URL of the built page from `here`; empty if there is none."""
        place = self._places.get((kind, name))
        return "" if place is None else self._way(place, here, ".html")

    def type(self, type_: Type, here: str) -> Markdown:
        """Return a type expression with its names as links."""
        match type_:
            case NamedType(name):
                return self.link(Kind.TYPE, "::".join(name), here)
            case SequenceType(element, bound):
                inner = self.type(element, here)
                end = "" if bound is None else f", {bound}"
                return Markdown(f"sequence&lt;{inner}{end}&gt;")
            case ArrayType(element, dimensions):
                ends = "".join(f"&#91;{n}&#93;" for n in dimensions)
                return Markdown(f"{self.type(element, here)}{ends}")
            case MapType(key, value, bound):
                end = "" if bound is None else f", {bound}"
                pair = f"{self.type(key, here)}, {self.type(value, here)}"
                return Markdown(f"map&lt;{pair}{end}&gt;")
        return code(str(type_))

    @staticmethod
    def _way(place: tuple[str, str], here: str, suffix: str) -> str:
        page, anchor = place
        path = posixpath.relpath(f"{page}{suffix}", posixpath.dirname(here) or ".")
        return f"{path}#{anchor}" if anchor else path

    def _free(self, wanted: str) -> str:
        name, number = wanted, self._numbers.get(wanted, 1)
        while name.casefold() in self._taken:
            number += 1
            name = f"{wanted}-{number}"
        self._taken.add(name.casefold())
        self._numbers[wanted] = number
        return name


def _plain(name: str) -> str:
    """Return the name in a form for paths and anchors."""
    made = _NOT_IN_PATHS.sub("-", name.replace("::", "-"))[:_MAX_LENGTH].strip("-")
    # `index` is the page of the folder.
    return made if made and made.lower() != "index" else f"{made or 'x'}-"
