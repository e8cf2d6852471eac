"""Two nodes, of which the second may be missing."""

from slaves import IDENTITY

from rtgen.runtime.canopen.description import Network, NodeDescription, Write

_NODES = tuple(
    NodeDescription(
        name=name,
        id=number,
        module="Drive",
        identity=IDENTITY,
        configuration=(Write(0x1017, 0, b"\x64\x00"),),
        pdos=(),
        heartbeat=100,
        heartbeat_timeout=300,
        mandatory=number == 5,
    )
    for number, name in ((5, "left"), (6, "right"))
)

NETWORK = Network("pair", 1000, 127, 10_000, 100, _NODES)
