"""Each door with stored and drawn inputs: it returns, or raises documented exceptions.

`make fuzz DOOR=NAME` explores one for longer.
"""

import logging
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from random import Random

import pytest
from doors import CORPUS, MODULES, corpus, door
from seeds import cases

DRAWN = 40
TAKES_ALL = {"node"}
"""Doors that refuse nothing: a node on a bus goes on, whatever the frames."""


@contextmanager
def quiet() -> Iterator[None]:
    """Suppress the warnings for bad input."""
    logging.disable()
    try:
        yield
    finally:
        logging.disable(logging.NOTSET)


@pytest.mark.parametrize("name", MODULES)
def test_kept_inputs(name: str, tmp_path: Path) -> None:
    opened = door(name, tmp_path)
    kept = [path.read_bytes() for path in corpus(name)]
    assert kept, f"tests/fuzz/harness.py {name} --keep makes a corpus"
    with quiet():
        accepted = [opened.enter(data) for data in kept]
    assert any(accepted), "only what is refused was kept"
    assert all(accepted) == (name in TAKES_ALL), "only what is accepted was kept"


@pytest.mark.sampled(10)
@pytest.mark.parametrize("name", MODULES)
def test_drawn_inputs(name: str, tmp_path: Path) -> None:
    opened = door(name, tmp_path)
    with quiet():
        for number in cases(DRAWN):
            opened.enter(opened.make(Random(number)))


def test_each_corpus_has_a_door() -> None:
    assert {path.name for path in CORPUS.iterdir()} == set(MODULES)
