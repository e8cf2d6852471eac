"""A project of many joins: lines of generated Python, and processor time of `rtgen generate`.

    python benchmarks/tecs_project.py [--joins N] [--functions N]

Each join has a signature of its own with that many functions (default: 100 joins of 20 functions).
Their parameters are of six kinds: numbers, arrays, texts, a struct.
"""

from __future__ import annotations

import os
import subprocess
import sys
import tempfile
import time
from pathlib import Path

from tables import Arguments, Results

PARAMETERS = (
    "[in] int32_t a",
    "[in] uint8_t b, [out] double64_t *r",
    "[in,size_is(n)] const int16_t *v, [in] int32_t n",
    "[in,string] const char_t *s, [out,string(32)] char_t *t",
    "[inout] struct tagItem *it",
    "[out,size_is(m)] int64_t *w, [in] int32_t m",
)
MAX_LINES = 25
"""Maximum number of Python lines for each function in a project of 100 joins of 20 functions."""


def project(joins: int, functions: int) -> str:
    """Return the CDL file."""
    lines = ["struct tagItem { int32_t id; float32_t w[4]; bool_t on; };"]
    for i in range(joins):
        lines.append(f"signature sBig{i} {{")
        for j in range(functions):
            parameters = PARAMETERS[(i + j) % len(PARAMETERS)]
            lines.append(f"  ER op{j}( {parameters} );")
        lines.append("};")
        lines.append(f"celltype tSrv{i} {{ entry sBig{i} eP; }};")
        lines.append(f"[active] celltype tCli{i} {{ call sBig{i} cP; }};")
    lines.append("region rServer {")
    lines += [f"  cell tSrv{i} Srv{i} {{ }};" for i in range(joins)]
    lines.append("};\n[to_through( rServer )] region rClient {")
    for i in range(joins):
        through = '[through( RTCPlugin, "" )]'
        lines.append(f"  cell tCli{i} Cli{i} {{ {through} cP = rServer::Srv{i}.eP; }};")
    return "\n".join([*lines, "};", ""])


def generate(folder: Path, joins: int, functions: int) -> tuple[int, float]:
    """Return the number of generated Python lines, and the processor time in seconds."""
    (folder / "big.cdl").write_text(project(joins, functions), encoding="utf-8")
    settings = '[sources]\npaths = ["big.cdl"]\n'
    (folder / "rtgen.toml").write_text(settings, encoding="utf-8")
    command = [sys.executable, "-m", "rtgen", "generate", "-q", "--no-cache"]
    before = os.times()
    subprocess.run(command, cwd=folder, check=True, capture_output=True)
    after = os.times()
    used = after.children_user - before.children_user
    used += after.children_system - before.children_system
    files = (folder / "generated").rglob("*.py")
    return sum(file.read_text("utf-8").count("\n") for file in files), used


def importing(folder: Path) -> float:
    """Return the processor time of importing one marshaller in seconds, without the runtime."""
    code = (
        "import time, rtgen.runtime, rtgen.runtime.opaque_rpc; t = time.process_time();"
        "import robots.tecs.big.big7_marshaller; print(time.process_time() - t)"
    )
    environment = {**os.environ, "PYTHONPATH": str(folder / "generated")}
    done = subprocess.run(
        [sys.executable, "-c", code],
        cwd=folder,
        check=True,
        capture_output=True,
        text=True,
        env=environment,
    )
    return float(done.stdout)


def main() -> int:
    """Print the figures; return 1 if there are too many lines."""
    parser = Arguments(__doc__, rounds=1)
    parser.add_argument("--joins", type=int, default=100)
    parser.add_argument("--functions", type=int, default=20)
    chosen = parser.parse_args()
    if chosen.smallest:
        chosen.joins, chosen.functions = 8, 2
    functions = chosen.joins * chosen.functions
    with Results(__file__, chosen) as results, tempfile.TemporaryDirectory() as name:
        table = results.table(
            "project",
            "joins",
            ("functions", ",d"),
            ("lines of Python", ",d"),
            ("for a function", ".1f"),
            ("processor time [s]", ".2f"),
            ("elapsed [s]", ".2f"),
            ("import of a marshaller [ms]", ".0f"),
        )
        folder = Path(name)
        start = time.perf_counter()
        lines, used = generate(folder, chosen.joins, chosen.functions)
        real = time.perf_counter() - start
        importing(folder)
        taken = importing(folder) * 1000
        each = lines / functions
        table.add(str(chosen.joins), functions, lines, each, used, real, taken)
    return int(not chosen.smallest and each > MAX_LINES)


if __name__ == "__main__":
    sys.exit(main())
