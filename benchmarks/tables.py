"""Options, tables and stored results of the benchmarks.

Each benchmark has the options of `Arguments` and prints the tables of a `Results`:

    def main() -> None:
        chosen = Arguments("What it measures.", rounds=3).parse_args()
        with Results(__file__, chosen) as results:
            table = results.table("chains", "chain", ("median [us]", ".0f"))
            table.add("periodic", 12.3)

With `--store` they are also written to `benchmarks/results/<benchmark>.json`, from which
`python benchmarks/speed_page.py` makes the tables of `docs/speed.md`, where a line
`<!-- table: <benchmark>/<table> -->` is. A file maps names of tables to

    date, commit    when and of which commit, with "+" if files differed from it
    machine         interpreter, architecture, number of processors
    rounds, load    number of rounds; least and greatest load of the machine, or a note
    columns         title and format specification (PEP 3101) of each
    rows            cells: numbers, formatted by their column; texts; null for none

A run replaces the tables that it measured; the others stay. `tests/test_benchmarks.py` starts each
benchmark with `--smallest`, and checks that the page has what is stored.
"""

from __future__ import annotations

import argparse
import json
import os
import platform
import subprocess
from datetime import UTC, datetime
from pathlib import Path
from typing import Any

FOLDER = Path(__file__).resolve().parent
RESULTS = FOLDER / "results"

Cell = str | float | None
Column = str | tuple[str, str]


class Arguments(argparse.ArgumentParser):
    """The options of a benchmark: `rounds`, `smallest`, `store`.

    `smallest` sets `rounds` to 1; the benchmark also takes its smallest inputs then.
    """

    def __init__(self, description: str | None, *, rounds: int) -> None:
        super().__init__(description=(description or "").partition("\n")[0])
        self.add_argument("--rounds", type=int, default=rounds)
        self.add_argument(
            "--smallest", action="store_true", help="one round of the smallest inputs"
        )
        self.add_argument(
            "--store", action="store_true", help="write the tables to results/"
        )

    def parse_args(self, *given: Any, **named: Any) -> Any:
        """Return the options."""
        chosen = super().parse_args(*given, **named)
        if chosen.smallest:
            chosen.rounds = 1
            if chosen.store:
                self.error("--store needs more than the smallest rounds")
        return chosen


class Table:
    """A table that is printed while it is filled. Columns are titles, or titles and formats."""

    def __init__(self, name: str, columns: tuple[Column, ...]) -> None:
        self.name = name
        self.columns = [(c, "") if isinstance(c, str) else c for c in columns]
        self.rows: list[list[Cell]] = []
        self._widths = [max(len(title), 9) + 2 for title, _ in self.columns]
        self._widths[0] = max(self._widths[0], 36)

    def add(self, *cells: Cell) -> None:
        """Add and print a row."""
        if len(cells) != len(self.columns):
            raise ValueError(f"{self.name} has {len(self.columns)} columns")
        if not self.rows:
            print(f"\n{self._line([title for title, _ in self.columns])}")
        self.rows.append(list(cells))
        formats = [format_ for _, format_ in self.columns]
        print(self._line([*map(text_of, cells, formats)]), flush=True)

    def _line(self, texts: list[str]) -> str:
        first, *others = zip(texts, self._widths, self.columns, strict=True)
        text = first[0].ljust(first[1])
        for each, width, (_, format_) in others:
            text += each.rjust(width) if format_ else f"  {each.ljust(width)}"
        return text.rstrip()


class Results:
    """The tables of one run of a benchmark, stored at its end if its options say so."""

    def __init__(self, script: str, options: Any) -> None:
        self._path = RESULTS / f"{Path(script).stem}.json"
        self._options = options
        self._tables: list[Table] = []
        self._load = [os.getloadavg()[0]]

    def __enter__(self) -> Results:
        return self

    def __exit__(self, kind: object, *_: object) -> None:
        if kind is None and self._options.store:
            self._load.append(os.getloadavg()[0])
            stored = read(self._path) if self._path.exists() else {}
            stored |= {each.name: self._stored(each) for each in self._tables}
            write(self._path, stored)

    def table(self, name: str, *columns: Column) -> Table:
        """Return a new table."""
        self._tables.append(Table(name, columns))
        return self._tables[-1]

    def _stored(self, table: Table) -> dict[str, Any]:
        return {
            "date": datetime.now(UTC).date().isoformat(),
            "commit": _commit(),
            "machine": f"Python {platform.python_version()}, {platform.machine()}, "
            f"{os.cpu_count()} processors",
            "rounds": self._options.rounds,
            "load": f"load {min(self._load):.1f} to {max(self._load):.1f}",
            "columns": table.columns,
            "rows": table.rows,
        }


def text_of(cell: Cell, format_: str) -> str:
    """Return the text of a cell."""
    if cell is None:
        return ""
    return cell if isinstance(cell, str) else format(cell, format_)


def read(path: Path) -> dict[str, Any]:
    """Return the tables of a file."""
    tables: dict[str, Any] = json.loads(path.read_text(encoding="utf-8"))
    return tables


def write(path: Path, tables: dict[str, Any]) -> None:
    """Write the tables of a file, a row a line."""
    texts = []
    for name, table in sorted(tables.items()):
        fields = {**table, "rows": []}
        head = json.dumps(fields, ensure_ascii=False, indent=1).removesuffix("[]\n}")
        rows = [json.dumps(row, ensure_ascii=False) for row in table["rows"]]
        lines = ",\n".join(rows)
        texts.append(f'"{name}": {head}[\n{lines}\n]}}')
    path.parent.mkdir(exist_ok=True)
    path.write_text("{\n" + ",\n".join(texts) + "\n}\n", encoding="utf-8")


def _commit() -> str:
    def git(*words: str) -> str:
        command = ["git", *words]
        done = subprocess.run(
            command, cwd=FOLDER, capture_output=True, text=True, check=False
        )
        return done.stdout.strip()

    changed = git("status", "--porcelain", "--", "../src", "../runtime", "../speed")
    return git("rev-parse", "--short=10", "HEAD") + "+" * bool(changed)
