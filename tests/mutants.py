"""Mutation testing of layouts, codecs, life cycle and SDO machines.

    python tests/mutants.py [PART...] [--jobs N]

Each part is source files and the narrow tests that should detect changes of them. Results are
stored in `build/mutants/PART`: a stopped run continues there, and changed files are run again. A
line for each part has the number of mutants caught; survivors follow, which `(cd build/mutants/PART
&& mutmut show NAME)` shows.
"""

from __future__ import annotations

import argparse
import json
import subprocess
import sys
from collections.abc import Mapping
from dataclasses import dataclass
from importlib.util import find_spec
from pathlib import Path

ROOT = Path(__file__).resolve().parent.parent
FOLDER = ROOT / "build/mutants"
_OWN = {"src", "build", "setup.cfg"}
"""Entries of the repository that a part has of its own, or does not need."""
_SLOW = "not slow and not peer"


@dataclass(frozen=True, slots=True)
class Part:
    """Files below `src/rtgen`, and tests below `tests/unit`."""

    sources: tuple[str, ...]
    tests: tuple[str, ...]


PARTS: Mapping[str, Part] = {
    "sdo": Part(
        (
            "runtime/canopen/wire/sdo.py",
            "runtime/canopen/wire/sdo_client.py",
            "runtime/canopen/wire/sdo_server.py",
        ),
        ("canopen/test_sdo.py",),
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
            "opaque_rpc/test_tcp_server.py",
            "opaque_rpc/test_shared_channel.py",
        ),
    ),
    "cdr": Part(
        (
            "runtime/marshalling/encoder.py",
            "runtime/marshalling/decoder.py",
            "runtime/marshalling/reader.py",
            "runtime/marshalling/writer.py",
            "runtime/marshalling/octets.py",
            "runtime/marshalling/octet_reader.py",
        ),
        ("types",),
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
    lists = {
        "source_paths": ["src"],
        "only_mutate": [f"src/rtgen/{source}" for source in part.sources],
        # A traceback would parse the mutated file, with all its mutants, for each of its frames.
        "pytest_add_cli_args": ["-p", "no:cacheprovider", "--tb=no", "-m", _SLOW],
        "pytest_add_cli_args_test_selection": [f"tests/unit/{t}" for t in part.tests],
    }
    lines = ["[mutmut]", "use_git_change_detection = false"]
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


def main() -> None:
    """Run the named parts, or all."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("parts", nargs="*", metavar="PART", help=", ".join(PARTS))
    parser.add_argument("--jobs", type=int, default=2, help="processes at once")
    given = parser.parse_args()
    if unknown := sorted(set(given.parts).difference(PARTS)):
        parser.error(f"there is no part {', '.join(unknown)}: {', '.join(PARTS)}")
    if find_spec("mutmut") is None:
        parser.error("mutmut is not installed: pip install mutmut")
    for name in given.parts or PARTS:
        print(mutated(name, given.jobs), flush=True)


if __name__ == "__main__":
    main()
