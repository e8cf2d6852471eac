"""Values of recursive types at every depth: a codec returns, or raises CdrError."""

from __future__ import annotations

import logging
import sys
from collections.abc import Iterator
from contextlib import contextmanager
from random import Random
from typing import Any

import emitted
import pytest
from seeds import cases

from rtgen.runtime.cdr import CdrError
from rtgen.runtime.distribution.data import Arrivals
from rtgen.runtime.distribution.medium import Sample

pytestmark = pytest.mark.random

IDL = """
module Deep {
  struct Final; typedef sequence<Final> Finals;
  struct Final { long v; Finals next; string s; };
  @appendable struct Appendable; typedef sequence<Appendable> Appendables;
  @appendable struct Appendable { long v; Appendables next; string s; };
  @mutable struct Mutable; typedef sequence<Mutable> Mutables;
  @mutable struct Mutable { long v; Mutables next; string s; };
  union Choice; typedef sequence<Choice> Choices;
  union Choice switch (boolean) { case TRUE: Choices next; case FALSE: long end; };
};
"""
TYPES = ("Final", "Appendable", "Mutable", "Choice")
FORMS = ("cdr", "xcdr1", "xcdr2")
DEEPEST = 3_000


@pytest.fixture(scope="module")
def deep(tmp_path_factory: pytest.TempPathFactory) -> Any:
    package = emitted.emit_text(tmp_path_factory.mktemp("deep"), IDL)
    return getattr(package, "deep", package)


@contextmanager
def recursion_limit(limit: int) -> Iterator[None]:
    before = sys.getrecursionlimit()
    sys.setrecursionlimit(limit)
    try:
        yield
    finally:
        sys.setrecursionlimit(before)


def nested(module: Any, name: str, depth: int) -> Any:
    """Return a value with `depth` levels."""
    type_ = getattr(module, name)
    make = getattr(type_, "of_next", lambda inner: type_(7, inner, "ab"))
    values: list[Any] = []
    for _ in range(depth):
        values = [make(values)]
    return values[0]


def octets(module: Any, name: str, form: str, depth: int) -> bytes:
    with recursion_limit(40 * DEEPEST):
        data: bytes = getattr(nested(module, name, depth), f"to_{form}")()
        return data


def damaged(data: bytes, random: Random) -> Iterator[bytes]:
    """Yield octets that are cut off, too long, or have wrong lengths."""
    yield data[:-1]
    yield data[: random.randrange(len(data))]
    yield data + b"\0" * random.randrange(1, 9)
    place = random.randrange(len(data) - 4)
    yield data[:place] + b"\xff\xff\xff\x7f" + data[place + 4 :]


@pytest.mark.parametrize("form", FORMS)
@pytest.mark.parametrize("name", TYPES)
def test_octets_of_each_depth(deep: Any, name: str, form: str) -> None:
    type_ = getattr(deep, name)
    decode = getattr(type_, f"from_{form}")
    refused = []
    for number in cases(8):
        random = Random(number)
        depth = int(2 ** random.uniform(0, 11.5))
        data = octets(deep, name, form, depth)
        for each in (data, *damaged(data, random)):
            try:
                decode(each)
            except CdrError as error:
                refused.append(error.path)
    assert refused
    assert all(path.startswith(name) for path in refused)


@pytest.mark.parametrize("form", FORMS)
@pytest.mark.parametrize("name", TYPES)
def test_values_of_each_depth(deep: Any, name: str, form: str) -> None:
    refused = {}
    for depth in (1, 100, 200, 300, 900, DEEPEST):
        value = nested(deep, name, depth)
        try:
            data = getattr(value, f"to_{form}")()
        except CdrError as error:
            refused[depth] = str(error)
        else:
            assert data == octets(deep, name, form, depth)
    assert DEEPEST in refused
    assert min(refused) > 100
    assert all("nested too deep" in message for message in refused.values())


def test_a_sample_that_is_too_deep_is_counted_and_reported_once(
    deep: Any, caplog: pytest.LogCaptureFixture
) -> None:
    arrivals = Arrivals("a connection", deep.Final)
    header = b"\0\1\0\0"  # CDR, little endian
    whole = octets(deep, "Final", "xcdr1", 150)
    with caplog.at_level(logging.WARNING):
        for number, data in enumerate((whole[:-1], whole[:-9], whole[:-1])):
            assert arrivals.taken(Sample(header + data, "one", number)) is None
    assert arrivals.invalid == 3
    assert caplog.text.count("cannot be decoded") == 1
