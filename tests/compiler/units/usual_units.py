"""Writes what pint says about usual units: python tests/compiler/units/usual_units.py"""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import pint

from rtgen.compiler.kit import units
from rtgen.facts.unit_symbols import DEFINITIONS, SYMBOLS, USUAL_NAMES, USUAL_SYMBOLS

FILE = Path(units.__file__).with_name("usual_units.json")
_MORE = ("bit", "bits", "counts", "meters", "pixels", "radians", "seconds")


def symbols() -> list[str]:
    """Return the symbols with stored units."""
    return sorted({*SYMBOLS, *USUAL_SYMBOLS, *USUAL_NAMES, *_MORE})


def content() -> dict[str, Any]:
    """Return what the file has to contain."""
    registry = pint.UnitRegistry(cache_folder=None)
    for definition in DEFINITIONS:
        registry.define(definition)
    return {
        "units": {symbol: units._defined_by_pint(symbol) for symbol in symbols()},
        "names": " ".join(sorted(registry._units)),
        "prefixes": " ".join(sorted(filter(None, registry._prefixes))),
    }


def main() -> None:
    """Write the file; names that only other versions of pint have stay in it."""
    new, stored = content(), json.loads(FILE.read_text("utf-8"))
    lines = (
        f"{json.dumps(symbol)}: {json.dumps(unit)}"
        for symbol, unit in new["units"].items()
    )
    kinds = ("names", "prefixes")
    for kind in kinds:
        words = {*new[kind].split(), *stored[kind].split()}
        new[kind] = " ".join(sorted(words))
    new["pint"] = max(pint.__version__, stored.get("pint", ""))
    rest = (f"{json.dumps(key)}: {json.dumps(new[key])}" for key in (*kinds, "pint"))
    text = '{"units": {\n' + ",\n".join(lines) + "\n},\n" + ",\n".join(rest) + "\n}\n"
    FILE.write_text(text, "utf-8")


if __name__ == "__main__":
    main()
