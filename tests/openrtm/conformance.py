"""The components of the reference build, and what makes them."""

from __future__ import annotations

import configparser
from importlib import import_module
from pathlib import Path

from rtgen.runtime import Component

GENERATED = Path(__file__).parents[2] / "generated"
LISTS = ("refrobots/components/entry_points.txt", "tecs/entry_points.txt")


class EntryPoints(configparser.ConfigParser):
    """Names keep their case."""

    def optionxform(self, optionstr: str) -> str:
        return optionstr


def behaviours() -> dict[str, str]:
    """Of every component of the reference build what makes it, `module:name`."""
    lists = EntryPoints()
    lists.read(GENERATED / file for file in LISTS)
    return {n: v for section in lists.sections() for n, v in lists[section].items()}


BEHAVIOURS = behaviours()


def component_of(name: str) -> Component:
    """An embedded component of a type: what the definition says, and the behaviour makes of it."""
    module, _, attribute = BEHAVIOURS[name].partition(":")
    made: Component = getattr(import_module(module), attribute)(f"{name}0")
    return made
