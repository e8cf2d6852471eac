"""Random pairs of versions of types: `rtgen diff` agrees with the codecs about encodings.

If no change breaks an encoding for a type, each version reads what the other wrote: all of it, or,
of appendable and mutable types, the common part. If one breaks it, a witness shows it.
"""

from __future__ import annotations

import re
import sys
from collections.abc import Callable, Iterator, Mapping
from pathlib import Path
from random import Random
from typing import Any

import pytest
import seeds
from hypothesis import HealthCheck, Phase, assume, given, seed, settings
from hypothesis import strategies as st
from wire_values import Reading, samples
from wire_versions import Drawing

sys.path.insert(0, str(Path(__file__).parents[2] / "compiler" / "types"))

from emitted import emit_text

from rtgen import api
from rtgen.compiler.diagnostics import has_errors
from rtgen.runtime.cdr import CdrError
from rtgen.runtime.marshalling.layouts.trees import has_headers
from rtgen.tools.diff.changes import Change, Wire
from rtgen.tools.diff.declarations import compare_declarations
from rtgen.tools.diff.versions import Version

ROOTS = ("Inner", "Choice", "Middle", "Outer")
MAX_WITNESSES = 400
EQUAL_READINGS = 12
_CALLED = re.compile(r"(\w+)\.(\w+) was called (\w+)")

Encode = Callable[[Any], bytes]
Decode = Callable[[Any, bytes], Any]

FORMS: Mapping[Wire, tuple[str, str]] = {
    Wire.CDR: ("to_cdr", "from_cdr"),
    Wire.XCDR1: ("to_xcdr1", "from_xcdr1"),
    Wire.XCDR2: ("to_xcdr2", "from_xcdr2"),
}


class Pair:
    """Two versions of a type, and the names of parts in the other version."""

    def __init__(self, old: Any, new: Any, changes: list[Change]) -> None:
        self._classes = (old, new)
        renamed = [m for c in changes if (m := _CALLED.search(c.message))]
        self._names = (
            {(m[1], m[3]): m[2] for m in renamed},
            {(m[1], m[2]): m[3] for m in renamed},
        )

    def readings(
        self, wire: Wire, random: Random, count: int
    ) -> Iterator[tuple[bool, object]]:
        """Yield whether a value was read as equal by the other version, for values of both."""
        to, from_ = FORMS[wire]
        classes = self._classes
        headed = all(has_headers(c._descriptor_) for c in classes)
        form = Wire.XCDR1 if wire is Wire.CDR and headed else wire
        for _ in range(count):
            for writer, reader, names in (
                (*classes, self._names[0]),
                (*classes[::-1], self._names[1]),
            ):
                [value] = samples(writer._descriptor_, random, 1)
                little = random.random() < 0.5
                octets = getattr(value, to)(little)
                try:
                    read = getattr(reader, from_)(octets, little)
                except CdrError as error:
                    yield False, (value, error)
                    continue
                same = Reading(form, names).same(
                    writer._descriptor_, value, reader._descriptor_, read, True
                )
                yield same, (value, read)


@pytest.mark.sampled(0)
@settings(
    deadline=None,
    database=None,
    phases=[Phase.generate],
    suppress_health_check=list(HealthCheck),
    max_examples=seeds.budget(40),
)
@seed(seeds.seed())
@given(random=st.integers(0, 1 << 32).map(Random))
def test_the_wire_is_as_diff_says(random: Random, tmp_path_factory: Any) -> None:
    drawing = Drawing(random)
    first = drawing.definitions()
    texts = (first.text(), drawing.changed(first).text())
    results = [api.read(text) for text in texts]
    assume(not any(has_errors(r.diagnostics) for r in results))  # clashing ids
    versions = [Version(r.model) for r in results]
    found = compare_declarations(*versions)
    folder: Path = tmp_path_factory.mktemp("versions")
    packages = []
    for number, text in enumerate(texts):
        below = folder / str(number)
        below.mkdir()
        packages.append(emit_text(below, text))
    for root in ROOTS:
        pair = Pair(*(getattr(p, root) for p in packages), found.changes)
        broken = found.broken.get((root,), frozenset())
        for wire in FORMS:
            if wire in broken:
                readings = pair.readings(wire, random, MAX_WITNESSES)
                shown = any(not same for same, _ in readings)
                assert shown, (root, wire, found.changes, texts)
            else:
                for same, values in pair.readings(wire, random, EQUAL_READINGS):
                    assert same, (root, wire, values, found.changes, texts)
