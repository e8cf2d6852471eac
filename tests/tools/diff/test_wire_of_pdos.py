"""Random changes of PDO mappings: `rtgen diff` agrees with the codecs."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from random import Random
from types import ModuleType
from typing import Any

import seeds
from hypothesis import HealthCheck, Phase, given, seed, settings
from hypothesis import strategies as st

from rtgen.compiler.backends import Options
from rtgen.compiler.backends.canopen.pdo_codec import Codecs, PdoCodec
from rtgen.compiler.backends.kit.python_module import python_module
from rtgen.compiler.backends.kit.rendering import render
from rtgen.compiler.diagnostics import Span
from rtgen.compiler.layouts.pdo import Mapped, layout
from rtgen.compiler.model.canopen import (
    BITS,
    Access,
    DataType,
    Device,
    DeviceInfo,
    FileInfo,
    NodeRelative,
    Object,
    ObjectType,
    Pdo,
    PdoDirection,
    PdoEntry,
    Variable,
)
from rtgen.runtime.canopen.pdo import PdoError
from rtgen.tools.diff.changes import Wire
from rtgen.tools.diff.devices import compare_pdos

OPTIONS = Options("codec", "codec", "1")
SPAN = Span("drive.eds", 1, 1, 1, 2)
TYPES = (
    *(DataType.BOOLEAN, DataType.INTEGER8, DataType.UNSIGNED8, DataType.INTEGER16),
    *(DataType.UNSIGNED16, DataType.INTEGER32, DataType.UNSIGNED32, DataType.REAL32),
)
MAX_WITNESSES = 60

Objects = dict[int, DataType]
"""The data types of mapped objects, by index."""


def device(objects: Objects, entries: Sequence[int]) -> Device:
    """Return a device with objects and one TPDO that maps some of them."""
    made = tuple(
        Object(
            index=index,
            name=f"Object {index:04X}",
            type=ObjectType.VAR,
            span=SPAN,
            variables=(
                Variable(
                    index=index,
                    subindex=0,
                    name=f"Object {index:04X}",
                    data_type=code,
                    access=Access.RO,
                    written_access="ro",
                    span=SPAN,
                    value_span=SPAN,
                    pdo_mappable=True,
                ),
            ),
        )
        for index, code in objects.items()
    )
    mapped = tuple(PdoEntry(i, 0, BITS[objects[i]]) for i in entries)
    pdo = Pdo(
        direction=PdoDirection.TPDO,
        number=1,
        cob_id=NodeRelative(0x180),
        transmission_type=255,
        entries=mapped,
        default_entries=mapped,
        span=SPAN,
    )
    return Device(
        name="Drive",
        file="drive.eds",
        key="drive.eds",
        sha256="",
        span=SPAN,
        node_id=None,
        file_info=FileInfo(),
        info=DeviceInfo(),
        commissioning=None,
        objects=made,
        pdos=(pdo,),
    )


Codec = tuple[Callable[..., bytes], Callable[[bytes], Any]]


def codec(objects: Objects, entries: Sequence[int]) -> Codec:
    """Return the functions of the generated codec."""
    mapped = [Mapped(f"o{i:04x}", objects[i], BITS[objects[i]]) for i in entries]
    codecs = [PdoCodec("tpdo1", "TPDO1", layout(mapped))]
    body = render("canopen/pdo_codecs.py.j2", codecs=Codecs(codecs, codecs))
    text = python_module("codec.py", OPTIONS, (), "Codecs.", body=body).text
    module = ModuleType("codec")
    exec(compile(text, "codec", "exec"), module.__dict__)
    return module.encode_tpdo1, module.decode_tpdo1


def value(code: DataType, random: Random) -> Any:
    """Return a value of a data type, other than zero."""
    if code is DataType.BOOLEAN:
        return random.random() < 0.5
    if code is DataType.REAL32:
        return random.choice((1.5, -2.25, 1024.0))
    bits = BITS[code]
    if code.name.startswith("INTEGER"):
        return random.choice((-1, 1, -(1 << bits - 1), (1 << bits - 1) - 1))
    return random.choice((1, (1 << bits) - 1, 1 << bits - 1))


def read_equal(
    objects: tuple[Objects, Objects],
    entries: tuple[list[int], list[int]],
    random: Random,
) -> bool:
    """Return whether the second version reads its mapped objects as the first one wrote them.

    A receiver uses the first octets of a longer PDO, and drops a shorter one.
    """
    (encode, _), (_, decode) = (
        codec(o, e) for o, e in zip(objects, entries, strict=True)
    )
    written = {i: value(objects[0][i], random) for i in entries[0]}
    octets = encode(*written.values())
    size = (sum(BITS[objects[1][i]] for i in entries[1]) + 7) // 8
    try:
        read = decode(octets[:size])
    except PdoError:
        return False
    found = dict(
        zip(entries[1], read if isinstance(read, tuple) else (read,), strict=True)
    )
    return all(
        index in written
        and type(written[index]) is type(item)
        and written[index] == item
        for index, item in found.items()
    )


def changed(objects: Objects, entries: list[int], random: Random) -> None:
    """Change a mapping or a mapped object."""
    match random.randrange(5):
        case 0 if len(entries) > 1:
            entries.pop(random.randrange(len(entries)))
        case 1:
            free = [i for i in objects if i not in entries]
            bits = sum(BITS[objects[i]] for i in entries)
            fitting = [i for i in free if bits + BITS[objects[i]] <= 64]
            if fitting:
                entries.insert(random.randint(0, len(entries)), random.choice(fitting))
        case 2:
            random.shuffle(entries)
        case 3:
            index = random.choice(entries)
            same = [t for t in TYPES if BITS[t] == BITS[objects[index]]]
            objects[index] = random.choice(same)
        case _:
            spare = [i for i in objects if i not in entries]
            if spare:
                objects[random.choice(spare)] = random.choice(TYPES)


@settings(
    deadline=None,
    database=None,
    phases=[Phase.generate],
    suppress_health_check=list(HealthCheck),
    max_examples=seeds.budget(80),
)
@seed(seeds.seed())
@given(random=st.integers(0, 1 << 32).map(Random))
def test_pdos_are_as_diff_says(random: Random) -> None:
    objects: Objects = {0x2000 + i: random.choice(TYPES) for i in range(6)}
    entries: list[int] = []
    for index in random.sample(sorted(objects), random.randint(1, 4)):
        if sum(BITS[objects[i]] for i in (*entries, index)) <= 64:
            entries.append(index)
    later_objects, later_entries = dict(objects), list(entries)
    changed(later_objects, later_entries, random)
    found = [
        *compare_pdos(device(objects, entries), device(later_objects, later_entries))
    ]
    broken = any(Wire.PDO in c.wires for c in found)
    ways = [
        ((objects, later_objects), (entries, later_entries)),
        ((later_objects, objects), (later_entries, entries)),
    ]
    readings = (
        read_equal(*way, random)
        for _ in range(MAX_WITNESSES if broken else 4)
        for way in ways
    )
    if broken:
        assert not all(readings), found
    else:
        assert all(readings), (found, ways[0])
