"""Table 4: generated proxy and device of one EDS exchange every data type, by PDO and by SDO."""

from __future__ import annotations

import sys
from collections.abc import Iterator
from pathlib import Path

import pytest
import table_4
from table_4 import Exchange

from rtgen.runtime import SimulatedClock


@pytest.fixture(scope="module")
def generated(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Path]:
    folder = table_4.generate(tmp_path_factory.mktemp("every_type"))
    sys.path.insert(0, str(folder))
    yield folder
    sys.path.remove(str(folder))


def check(exchange: Exchange) -> None:
    exchange.activate()
    for number, sent, got in exchange.pdos():
        assert got == sent, f"PDO {number}"
        assert [str(v) for row in got for v in row] == [
            str(v) for row in sent for v in row
        ], "the sign of zero, too"
    for name, wanted, got in exchange.objects():
        assert got == wanted, name
    assert exchange.system.statistics("Proxy0").lost == 0


def test_in_simulated_time(generated: Path) -> None:
    with Exchange(SimulatedClock(), {"node_id": 5, "master": True}) as exchange:
        device = table_4.configured(table_4.device("Device0"), {"node_id": 5})
        exchange.system.add(device, 200.0)
        check(exchange)
