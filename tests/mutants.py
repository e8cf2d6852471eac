"""Mutation testing of layouts, codecs, life cycle and SDO machines.

    python tests/mutants.py [PART...] [--jobs N]

Each part is source files and the narrow tests that should detect changes of them. Results are
stored in `build/mutants/PART`: a stopped run continues there, and changed files are run again. A
line for each part has the number of mutants of functions caught; survivors follow, which
`(cd build/mutants/PART && mutmut show NAME)` shows. A second line, with its survivors, is about
tables and constants outside of functions (`table_mutants.py`); `--tables` runs those alone.
"""

from __future__ import annotations

import argparse
import json
import subprocess
import sys
import time
from collections.abc import Iterator, Mapping
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass
from importlib.util import find_spec
from pathlib import Path

import table_mutants
from table_mutants import Mutant

ROOT = Path(__file__).resolve().parent.parent
FOLDER = ROOT / "build/mutants"
_OWN = {"src", "build", "setup.cfg"}
"""Entries of the repository that a part has of its own, or does not need."""
_ARGUMENTS = ("-p", "no:cacheprovider", "--tb=no", "-m", "not slow and not peer")
"""A traceback would parse the mutated file, with all its mutants, for each of its frames."""


@dataclass(frozen=True, slots=True)
class Part:
    """Files below `src/rtgen`, and tests below `tests/unit`; `conftest` is one for mutmut."""

    sources: tuple[str, ...]
    tests: tuple[str, ...]
    conftest: str = ""


PARTS: Mapping[str, Part] = {
    "sdo": Part(
        (
            "runtime/canopen/wire/sdo.py",
            "runtime/canopen/wire/sdo_client.py",
            "runtime/canopen/wire/sdo_server.py",
        ),
        (
            "canopen/test_sdo.py",
            "canopen/test_sdo_bounds.py",
            "canopen/test_sdo_codes.py",
            "canopen/test_sdo_messages.py",
        ),
    ),
    "life-cycle": Part(
        (
            "runtime/rtc/life_cycle.py",
            "runtime/rtc/callbacks.py",
            "runtime/rtc/participant.py",
            "runtime/rtc/execution_context.py",
        ),
        (
            "runtime/test_life_cycle_table.py",
            "runtime/test_timetable.py",
            "runtime/test_failing_callbacks.py",
            "runtime/test_gated_requests.py",
            "runtime/test_component_base.py",
            "runtime/test_callback_reports.py",
            "runtime/test_shared_contexts.py",
        ),
    ),
    "pdo": Part(
        ("layouts/pdo.py", "layouts/can_values.py"),
        (
            "canopen/test_pdo_codec.py",
            "canopen/test_can_startup.py",
            "facts/test_canopen.py",
        ),
    ),
    "offsets": Part(
        ("layouts/offsets.py", "layouts/cdr_types.py"),
        ("types/test_offsets.py", "types/test_cdr_types.py"),
    ),
    "tdr-layouts": Part(
        ("layouts/tdr.py", "layouts/tdr_messages.py"),
        (
            "tecs/test_tdr_layouts.py",
            "tecs/test_codec_bytes.py",
            "tecs/test_codec_text.py",
        ),
    ),
    "tdr": Part(
        (
            "runtime/opaque_rpc/tdr.py",
            "runtime/opaque_rpc/values.py",
            "runtime/opaque_rpc/codecs.py",
            "runtime/opaque_rpc/messages.py",
        ),
        (
            "tecs/test_opaque_rpc_values.py",
            "tecs/test_message_calls.py",
            "tecs/test_codec_bytes.py",
            "tecs/test_signature_digest.py",
            "opaque_rpc/test_tcp_server.py",
            "opaque_rpc/test_shared_channel.py",
        ),
    ),
    "cdr": Part(
        (
            "runtime/marshalling/source/encoder.py",
            "runtime/marshalling/source/decoder.py",
            "runtime/marshalling/dynamic/reader.py",
            "runtime/marshalling/dynamic/writer.py",
            "runtime/marshalling/octets.py",
            "runtime/marshalling/dynamic/octet_reader.py",
        ),
        ("types",),
        "fresh_codecs.py",
    ),
}


def _prepare(name: str) -> Path:
    """Return a folder for mutmut: mutated sources beside links to all files that tests read."""
    part = PARTS[name]
    folder = FOLDER / name
    (folder / "mutants").mkdir(parents=True, exist_ok=True)
    for entry in ROOT.iterdir():
        link = folder / "mutants" / entry.name
        if entry.name not in _OWN and entry.name[0] != "." and not link.is_symlink():
            link.symlink_to(entry)
    if not (folder / "src").is_symlink():
        (folder / "src").symlink_to(ROOT / "src")
    conftest = folder / "mutants/conftest.py"
    if part.conftest and not conftest.is_symlink():
        conftest.symlink_to(ROOT / "tests" / part.conftest)
    lists = {
        "source_paths": ["src"],
        "only_mutate": [f"src/rtgen/{source}" for source in part.sources],
        "pytest_add_cli_args": list(_ARGUMENTS),
        "pytest_add_cli_args_test_selection": [f"tests/unit/{t}" for t in part.tests],
    }
    lines = ["[mutmut]", "use_git_change_detection = false", "timeout_multiplier = 5"]
    for key, values in lists.items():
        lines += [f"{key} =", *(f"    {value}" for value in values)]
    (folder / "setup.cfg").write_text("\n".join(lines) + "\n")
    return folder


def _mutmut(folder: Path, *arguments: str) -> subprocess.CompletedProcess[str]:
    return subprocess.run(
        [sys.executable, "-m", "mutmut", *arguments],
        cwd=folder,
        capture_output=True,
        text=True,
        check=False,
    )


def mutated(name: str, jobs: int) -> str:
    """Run the rest of a part; return the number of mutants caught, and the survivors."""
    folder = _prepare(name)
    done = _mutmut(folder, "run", "--max-children", str(jobs))
    if done.returncode != 0:
        raise SystemExit(f"{name}: {done.stdout[-4000:]}{done.stderr[-4000:]}")
    _mutmut(folder, "export-cicd-stats")
    counts = json.loads((folder / "mutants/mutmut-cicd-stats.json").read_text())
    caught, total = counts["killed"] + counts["timeout"], counts["total"]
    survivors = _mutmut(folder, "results").stdout.rstrip()
    return f"{name}: {caught} of {total} caught, {caught / total:.1%}\n{survivors}"


def _tables(part: Part) -> Iterator[tuple[str, Path, Mutant]]:
    """Yield the mutants of tables, each with its module and file."""
    for source in part.sources:
        path = ROOT / "src/rtgen" / source
        module = f"rtgen.{source.removesuffix('.py').replace('/', '.')}"
        for mutant in table_mutants.mutants(path.read_text()):
            yield module, path, mutant


def tables(name: str, jobs: int) -> str:
    """Return the number of mutants of a part's tables that were caught, and the survivors."""
    part = PARTS[name]
    tests = [str(ROOT / "tests/unit" / test) for test in part.tests]
    arguments = [*_ARGUMENTS, "-x", "-q", "--rootdir", str(ROOT), *tests]
    found = list(_tables(part))
    if not found:
        return f"{name}, tables: none"
    module, path, _ = found[0]
    start = time.monotonic()
    if table_mutants.caught(module, path, path.read_text(), arguments, 600.0):
        raise SystemExit(f"{name}: the tests fail without any change")
    patience = 30.0 + 10 * (time.monotonic() - start)

    def survivor(each: tuple[str, Path, Mutant]) -> str:
        module, path, mutant = each
        if table_mutants.caught(module, path, mutant.source, arguments, patience):
            return ""
        return f"    {module}:{mutant}"

    with ThreadPoolExecutor(jobs) as pool:
        survivors = [line for line in pool.map(survivor, found) if line]
    count, total = len(found) - len(survivors), len(found)
    lines = [f"{name}, tables: {count} of {total} caught, {count / total:.1%}"]
    return "\n".join([*lines, *survivors])


def main() -> None:
    """Run the named parts, or all."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("parts", nargs="*", metavar="PART", help=", ".join(PARTS))
    parser.add_argument("--jobs", type=int, default=2, help="processes at once")
    parser.add_argument("--tables", action="store_true", help="tables alone")
    given = parser.parse_args()
    if unknown := sorted(set(given.parts).difference(PARTS)):
        parser.error(f"there is no part {', '.join(unknown)}: {', '.join(PARTS)}")
    if find_spec("mutmut") is None and not given.tables:
        parser.error("mutmut is not installed: pip install mutmut")
    for name in given.parts or PARTS:
        if not given.tables:
            print(mutated(name, given.jobs), flush=True)
        print(tables(name, given.jobs), flush=True)


if __name__ == "__main__":
    main()
