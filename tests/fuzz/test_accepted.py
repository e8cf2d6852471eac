"""Python generated from accepted definitions imports, round-trips and type-checks."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path
from random import Random

import pytest
from accepted import DOORS, Packages
from doors import corpus, door
from seeds import cases
from test_doors import quiet

DRAWN = 5


def _inputs(name: str, folder: Path) -> Iterator[tuple[str, bytes]]:
    """Yield the stored inputs of a door, and some drawn ones, by name."""
    for path in corpus(name):
        yield path.name, path.read_bytes()
    opened = door(name, folder)
    for number in cases(DRAWN):
        yield str(number), opened.make(Random(number))


@pytest.mark.nightly
def test_packages_of_stored_and_drawn_inputs(tmp_path: Path) -> None:
    packages = Packages(tmp_path / "packages")
    with quiet():
        for name in DOORS:
            folder = tmp_path / name
            folder.mkdir()
            made = [
                packages.add(f"{name}_{each}".replace("-", "_"), name, data)
                for each, data in _inputs(name, folder)
            ]
            assert any(made) or name in NOTHING_STORED, name
    packages.check_types()
    assert not packages.failures, "\n".join(packages.failures.values())


NOTHING_STORED = {"cdl"}
"""Doors whose stored inputs are accepted with nothing to generate, or refused."""


def test_failures_have_the_names_of_inputs(tmp_path: Path) -> None:
    packages = Packages(tmp_path)
    for name in ("sound", "wrong"):
        assert packages.add(name, "idl", b"struct S { long a; };")
    assert not packages.add("refused", "idl", b"struct S { long a }")
    file = tmp_path / "wrong/_idl/input.py"
    file.write_text(file.read_text() + "x: int = ''\n")
    packages.check_types()
    [(name, message)] = packages.failures.items()
    assert name == "wrong"
    assert 'expression has type "str", variable has type "int"' in message
