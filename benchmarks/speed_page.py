"""Makes the tables of `docs/speed.md` of the stored results.

    python benchmarks/speed_page.py

A table is between the lines `<!-- table: <benchmark>/<table> -->` and `<!-- end of table -->` of
the page; its last line says how it was measured. The rest of the page is written by hand.
"""

from __future__ import annotations

import re
from pathlib import Path
from typing import Any

import tables

PAGE = tables.FOLDER.parent / "docs" / "speed.md"
PLACE = re.compile(
    r"(?<=<!-- table: )([\w/-]+)( -->\n).*?(?=<!-- end of table -->)", re.DOTALL
)


def stored() -> dict[str, Any]:
    """Return all stored tables by `<benchmark>/<table>`."""
    return {
        f"{path.stem}/{name}": table
        for path in sorted(tables.RESULTS.glob("*.json"))
        for name, table in tables.read(path).items()
    }


def updated(page: str, found: dict[str, Any]) -> str:
    """Return the page with the stored tables. Raises KeyError for one that is not stored."""
    return PLACE.sub(lambda m: f"{m[1]}{m[2]}\n{_text(m[1], found[m[1]])}\n", page)


def _text(name: str, table: dict[str, Any]) -> str:
    titles, formats = zip(*table["columns"], strict=True)
    lines = [titles, ["---", *("--:" if f else "---" for f in formats[1:])]]
    lines += [map(tables.text_of, row, formats) for row in table["rows"]]
    text = "".join(f"| {' | '.join(line)} |\n" for line in lines)
    script = f"{name.partition('/')[0]}.py"
    facts = [table["date"], table["commit"] and f"commit {table['commit']}"]
    facts += [table["rounds"] and f"{table['rounds']} rounds", table["machine"]]
    return (
        f"{text}\n*`{script}`: {', '.join(filter(None, (*facts, table['load'])))}.*\n"
    )


def main() -> None:
    """Write the page."""
    text = PAGE.read_text(encoding="utf-8")
    Path(PAGE).write_text(updated(text, stored()), encoding="utf-8")


if __name__ == "__main__":
    main()
