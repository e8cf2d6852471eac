"""`rtgen inspect` of large CDL files compared with tecsgen: processor time of whole processes.

    python benchmarks/cdl.py

Signatures: 300 of 20 functions with a server, a client and a join each. Cells: 10 small signatures,
1,500 cells in 30 regions, each joined to the one before, with a comment of three lines above. rtgen
runs without its cache; tecsgen 1.7, found by RTGEN_TECSGEN or the path, includes its generation of
code. The runs are interleaved, the least of each counts.
"""

from __future__ import annotations

import os
import resource
import shutil
import subprocess
import sys
import tempfile
from collections.abc import Iterator, Sequence
from pathlib import Path

from tables import Arguments, Results

SIGNATURES, FUNCTIONS = 300, 20
LIMIT = 0.5
"""Maximum ratio to tecsgen's processor time."""

PARAMETERS = (
    "[in] int32_t a",
    "[in] uint8_t b, [out] double64_t *r",
    "[in,size_is(n)] const int16_t *v, [in] int32_t n",
    "[in,string] const char_t *s, [out,string(32)] char_t *t",
    "[inout] struct tagItem *it",
    "[out,size_is(m)] int64_t *w, [in] int32_t m",
)


def synthetic() -> Iterator[str]:
    """Yield the lines of the CDL file."""
    yield "struct tagItem { int32_t id; float32_t w[4]; bool_t on; };"
    for i in range(SIGNATURES):
        yield f"signature sBig{i} {{"
        for j in range(FUNCTIONS):
            parameters = PARAMETERS[(i + j) % len(PARAMETERS)]
            yield f"  int32_t op{j}( {parameters} );"
        yield "};"
        yield f"celltype tServer{i} {{ entry sBig{i} eP; attr {{ int32_t k = {i}; }}; }};"
        yield f"[active] celltype tClient{i} {{ call sBig{i} cP; }};"
        yield f"cell tServer{i} Server{i} {{ k = {i + 1}; }};"
        yield f"cell tClient{i} Client{i} {{ cP = Server{i}.eP; }};"


def cells() -> Iterator[str]:
    """Yield the lines of a file of many cells."""
    for i in range(10):
        yield f"signature sLink{i} {{ int32_t get( [in] int32_t index ); }};"
        yield f"celltype tFirst{i} {{ entry sLink{i} eP; attr {{ int32_t k = {i}; }}; }};"
        yield f"[active] celltype tLink{i} {{"
        yield f"  entry sLink{i} eP; call sLink{i} cP;"
        yield "  attr { int32_t k = 0; };"
        yield "};"
    for region in range(30):
        kind = region % 10
        yield f"region rPart{region} {{"
        yield f"  cell tFirst{kind} First{region} {{ }};"
        before = f"First{region}.eP"
        for i in range(50):
            yield f"  /* The link of number {i} in part {region}:"
            yield "   * what it is asked for is answered by the one before,"
            yield "   * or by the first. */"
            yield f"  cell tLink{kind} Link{region}_{i} {{ cP = {before}; k = {i}; }};"
            before = f"Link{region}_{i}.eP"
        yield "};"


SHAPES = {"signatures": synthetic, "cells": cells}


def processor_time(command: Sequence[str], folder: Path) -> float:
    """Return user and system time [s] of a process, which must succeed."""

    def total() -> float:
        used = resource.getrusage(resource.RUSAGE_CHILDREN)
        return used.ru_utime + used.ru_stime

    before = total()
    subprocess.run(command, cwd=folder, check=True, capture_output=True)
    return total() - before


def main() -> int:
    """Print the times; return 1 if rtgen exceeds the limit for the first file."""
    chosen = Arguments(__doc__, rounds=5).parse_args()
    tecsgen = os.environ.get("RTGEN_TECSGEN") or shutil.which("tecsgen")
    rtgen = str(Path(sys.executable).with_name("rtgen"))
    commands = {"rtgen": [rtgen, "inspect", "--no-cache", "big.cdl"]}
    if tecsgen is None:
        print("tecsgen is missing")
    else:
        commands["tecsgen"] = [tecsgen, "-g", "gen", "big.cdl"]
    missed = False
    with Results(__file__, chosen) as results:
        table = results.table(
            "files",
            "file",
            ("lines", ",d"),
            ("rtgen [s]", ".2f"),
            ("tecsgen [s]", ".2f"),
            ("ratio", ".2f"),
            ("limit", ".1f"),
        )
        for shape, lines in SHAPES.items():
            best = dict.fromkeys(commands, float("inf"))
            with tempfile.TemporaryDirectory() as name:
                folder = Path(name)
                text = "\n".join(lines())
                (folder / "big.cdl").write_text(text, encoding="utf-8")
                for _ in range(chosen.rounds):
                    for tool, command in commands.items():
                        seconds = processor_time(command, folder)
                        best[tool] = min(best[tool], seconds)
            theirs = best.get("tecsgen")
            share = None if theirs is None else best["rtgen"] / theirs
            number = text.count("\n") + 1
            table.add(shape, number, best["rtgen"], theirs, share, LIMIT)
            missed |= shape == "signatures" and share is not None and share > LIMIT
    return int(missed and not chosen.smallest)


if __name__ == "__main__":
    raise SystemExit(main())
