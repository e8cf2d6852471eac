"""What passes through a proxy: samples both ways, parameters, objects by SDO."""

from __future__ import annotations

import struct

from proxy_bench import Bench


def ready(**settings: object) -> Bench:
    """A proxy, INACTIVE, whose node has booted."""
    bench = Bench(settings=settings)
    bench.with_node()
    bench.run(0.05)
    return bench


def active(**settings: object) -> Bench:
    bench = ready(**settings)
    bench.activate()
    return bench


def test_parameters_are_written_at_activation() -> None:
    with active(Acceleration=7) as bench:
        assert bench.node.objects.writes == [
            ((0x1017, 0), struct.pack("<H", 100)),
            ((0x6083, 0), struct.pack("<I", 7)),
        ]
