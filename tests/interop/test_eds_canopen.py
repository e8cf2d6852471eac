"""Real EDS and DCF files, compared with the `canopen` package.

Known errors of the package are excluded from the comparison one by one.
"""

from __future__ import annotations

import json
import logging
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pytest

from rtgen.compiler.diagnostics import has_errors
from rtgen.compiler.frontends.eds import load
from rtgen.compiler.frontends.eds.variables import KNOWN
from rtgen.compiler.model.canopen import Device, NodeRelative, Variable, resolved

ROOT = Path(__file__).parents[2]
GOLDEN = ROOT.parent / "shared" / "golden" / "eds"
EXPECTED = GOLDEN / "expected.json"
OURS = sorted((ROOT / "specs").rglob("*.eds"))

NODE = 5
"""The node-id for EDS files in the golden data."""

_FIRST_OBJECT = 0x1000

canopen = pytest.importorskip("canopen", reason="the package canopen is not installed")
needs_files = pytest.mark.skipif(
    not EXPECTED.exists(), reason="no device descriptions of others at ../shared"
)


def golden() -> dict[str, Any]:
    """Return the package's result for each file, by name."""
    if not EXPECTED.exists():
        return {}
    files: dict[str, Any] = json.loads(EXPECTED.read_text(encoding="utf-8"))["files"]
    return files


def read(path: Path, node_id: int | None) -> Device:
    """Return the device of a file that is read without errors."""
    result = load([path], root=path.parent, node_id=node_id)
    assert not has_errors(result.diagnostics), result.diagnostics
    [device] = result.model.devices
    return device


def variables(path: Path, node_id: int | None) -> Iterator[Any]:
    """Yield the package's variables."""
    logging.disable(logging.CRITICAL)
    try:
        dictionary = canopen.import_od(str(path), node_id)
    finally:
        logging.disable(logging.NOTSET)
    for thing in dictionary.values():
        yield from getattr(thing, "subindices", {0: thing}).values()


def same_default(ours: Variable, theirs: Any, node_id: int | None) -> bool:
    """Return whether the package agrees, or has a value with a known error."""
    value = resolved(ours.default, node_id)
    if value == theirs.default or isinstance(value, NodeRelative):
        return True
    if theirs.default in ("", b""):
        return value is None
    unfolded = isinstance(value, int) and value < 0
    return theirs.default is None or (
        unfolded and theirs.default == value + (1 << (ours.bits or 0))
    )


def compare(path: Path, node_id: int | None) -> int:
    """Compare the variables of a file; return the number of common ones."""
    device = read(path, node_id)
    known = {(v.index, v.subindex): v for v in device.variables}
    compact = {o.index for o in device.objects if _made_up(device, o.index)}
    count = 0
    for theirs in variables(path, node_id):
        if theirs.index < _FIRST_OBJECT:
            assert theirs.index in device.dummies
            continue
        place = (theirs.index, theirs.subindex)
        ours = known[place]
        count += 1
        if ours.data_type in KNOWN:
            assert ours.data_type == theirs.data_type, place
        if theirs.index in compact and theirs.subindex == 0:
            continue
        assert ours.written_access == theirs.access_type, place
        assert ours.name == theirs.name or theirs.index in compact or not theirs.name
        assert same_default(ours, theirs, node_id), place
    return count


def _made_up(device: Device, index: int) -> bool:
    """Return whether an object's members come from its head, so the package has no sub 0."""
    first, second = device.find(index), device.find(index, 1)
    return first is not None and second is not None and first.span == second.span


@pytest.mark.sampled(4)
@needs_files
@pytest.mark.parametrize(
    "name", [n for n, facts in golden().items() if not facts.get("exception")]
)
def test_what_the_package_reads(name: str) -> None:
    facts = golden()[name]
    node_id = NODE if facts["kind"] == "eds" else None
    path = GOLDEN / name
    assert compare(path, node_id) > 0
    device = read(path, node_id)
    pdos = {(p.direction.value, p.number): p for p in device.pdos}
    wanted = {
        (way, int(n)): p for way in ("tpdo", "rpdo") for n, p in facts[way].items()
    }
    assert set(pdos) == set(wanted)
    for key, theirs in wanted.items():
        ours = pdos[key]
        assert ours.transmission_type == theirs["trans"]
        if theirs["cob_id"] is not None:
            cob_id = resolved(ours.cob_id, device.node_id)
            assert isinstance(cob_id, int)
            assert f"{cob_id:#x}" == theirs["cob_id"]
        if "map" in theirs:
            entries = [[f"{e.index:#x}", e.subindex, e.bits] for e in ours.entries]
            assert entries == theirs["map"]


@needs_files
@pytest.mark.parametrize(
    "name", [n for n, facts in golden().items() if facts.get("exception")]
)
def test_what_the_package_rejects(name: str) -> None:
    facts = golden()[name]
    result = load([GOLDEN / name], root=GOLDEN)
    if not facts["lenient"]["objects"]:
        assert [d.code for d in result.diagnostics] == ["EDS0006"]
        return
    [device] = result.model.devices
    implied = [o for o in device.objects if o.span == device.span]
    assert len(device.objects) - len(implied) == facts["lenient"]["objects"]
    assert bool(implied) == bool(device.info.compact_pdo)


@pytest.mark.parametrize("path", OURS, ids=lambda path: path.stem)
def test_our_own(path: Path) -> None:
    assert load([path], root=ROOT).diagnostics == ()
    assert compare(path, NODE) == sum(1 for _ in read(path, NODE).variables)
