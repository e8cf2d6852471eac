"""Values of each kind: rtgen's codecs in C and in Python beside omniORBpy and msgspec.

    python benchmarks/values.py [TITLE...]

Rounds of all candidates are interleaved; the least processor time is printed, in nanoseconds. A
ratio over 1 is how many times as fast the codecs in C are. They are those of `rtgen-speed`, which
has to be installed or built by `python tests/speed.py`. msgspec's msgpack takes the same objects;
omniORB has no types with headers. `cdr.py` compares with more peers.
"""

from __future__ import annotations

import importlib
import os
import sys
import tempfile
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

import cdr
import msgspec
from cdr_peers import load_omniorb, omniorb_type, omniorb_value
from tables import Arguments, Results

FOLDER = Path(__file__).resolve().parent
BUILT = FOLDER.parent / "build" / "speed"
FILES = [FOLDER / "values_types.idl", FOLDER / "values_xtypes.idl"]

WAYS = "encode", "decode"

Task = Callable[[], object]


def generated(folder: Path) -> tuple[Any, Any]:
    """Return the generated packages of both files."""
    from rtgen.compiler.backends import Options
    from rtgen.compiler.backends.types.backend import BACKEND
    from rtgen.compiler.frontends.idl import load
    from rtgen.compiler.lowering.numeric import lower
    from rtgen.compiler.lowering.settings import Settings

    model = lower(load(FILES, root=FOLDER).model, Settings(numeric="array")).model
    for artifact in BACKEND.emit(model, Options("bench_values", "s", "0")).artifacts:
        path = folder / artifact.path
        path.parent.mkdir(parents=True, exist_ok=True)
        path.write_text(artifact.text, encoding="utf-8")
    sys.path.insert(0, str(folder))
    names = ("values", "extended")
    values, extended = (importlib.import_module(f"bench_values.{n}") for n in names)
    return values, extended


def samples(v: Any, x: Any) -> Iterator[tuple[str, Any]]:
    """Yield a title and a value of each kind."""
    from rtgen.runtime.marshalling.descriptors import StringDescriptor
    from rtgen.runtime.values import AnyValue

    fixed = v.Plain(1 << 40, 0.5, 1.5, 2.5, 7, True)
    names = [f"joint_{n}_of_the_arm" for n in range(20)]
    inner = v.Inner("laser", [n / 7 for n in range(20)])
    reading = [v.Choice(v.Hue.RED, 5), v.Choice(v.Hue.GREEN, "near")]
    reading.append(v.Choice(v.Hue.BLUE, fixed))
    yield "fixed", fixed
    yield "a string", v.Text("a message of a robot")
    yield "20 strings", v.Texts(names)
    yield "a wide string", v.Wide("a message, 漢字")
    yield "20 wide strings", v.Wides(names)
    yield "nested sequences", v.Nested([inner] * 10)
    yield "12 unions", v.Choices(reading * 4)
    yield "50 structs", v.Points([v.Point(n / 7, n / 9, n) for n in range(50)])
    yield "50 enumerators", v.Hues([v.Hue(n % 3) for n in range(50)])
    yield "scan of 720", v.Scan(1, [n / 8 for n in range(720)])
    yield "arrays", v.Grid([[n / 7 for n in range(6)]] * 6, [*range(12)])
    yield "1,000 octets", v.Octets(bytes(range(250)) * 4)
    yield "any of a struct", v.Held(AnyValue(v.Plain._descriptor_, fixed))
    yield "any of a string", v.Held(AnyValue(StringDescriptor(), "a message"))
    yield "optional members", x.Maybe(None, "a note", 5)
    yield "map of 10", x.Map({name: n for n, name in enumerate(names[:10])})
    yield "appendable", x.Grown("arm", 2.5)
    yield "mutable", x.Loose("arm", 2.5, 3)


def _omniorb(value: Any) -> tuple[Task, Task]:
    import omniORB
    from omniORB import CORBA

    described = value._descriptor_
    code = omniorb_type(described)
    held = getattr(value, "content", None)
    if hasattr(held, "_descriptor_"):
        is_text = isinstance(held.value, str)
        inner = CORBA.TC_string if is_text else omniorb_type(held.type)
        content = held.value if is_text else omniorb_value(held.type, held.value)
        theirs = omniORB.findType(described.repository_id)[1](CORBA.Any(inner, content))
    else:
        theirs = omniorb_value(described, value)
    octets = omniORB.cdrMarshal(code, theirs, 1)
    marshal, unmarshal = omniORB.cdrMarshal, omniORB.cdrUnmarshal
    return lambda: marshal(code, theirs, 1), lambda: unmarshal(code, octets, 1)


def _msgspec(value: Any) -> tuple[Task, Task]:
    packed = msgspec.msgpack.encode(value)
    pack, unpack = msgspec.msgpack.Encoder().encode, msgspec.msgpack.Decoder
    is_union = "Choice" in type(value).__name__
    decode = unpack(Any if is_union else type(value)).decode
    return lambda: pack(value), lambda: decode(packed)


def candidates(value: Any) -> Iterator[tuple[str, Task, Task]]:
    """Yield the name, the encoder and the decoder of each candidate that takes the value."""
    from rtgen.runtime.marshalling.compiler import compiled, compiled_in_python
    from rtgen.runtime.marshalling.layouts.formats import CLASSIC, Format

    type_ = type(value)
    described = type_._descriptor_
    is_classic = described.name.startswith("Values::")
    format_ = CLASSIC if is_classic else Format(2)
    for name, found in (("in C", compiled), ("in Python", compiled_in_python)):
        encode, decode = (found(k, described, format_) for k in ("to_cdr", "from_cdr"))
        octets = encode(value)
        assert decode(type_, octets) == value
        yield name, *_tasks(encode, decode, value, octets)
    peers = {"omniORBpy": _omniorb} if is_classic else {}
    for name, peer in (*peers.items(), ("msgspec msgpack", _msgspec)):
        try:
            yield name, *peer(value)
        except (AttributeError, TypeError, KeyError):
            continue  # it has no such type


def _tasks(
    encode: Callable[..., bytes], decode: Callable[..., Any], value: Any, octets: bytes
) -> tuple[Task, Task]:
    """Return tasks whose calls have their arguments written out, like those of the peers."""
    type_ = type(value)
    return lambda: encode(value), lambda: decode(type_, octets)


def main() -> None:
    """Print the times in C, and the ratio of each candidate's to them."""
    parser = Arguments(__doc__, rounds=cdr.ROUNDS)
    parser.add_argument("titles", nargs="*", help="titles of values")
    chosen = parser.parse_args()
    sys.path.append(str(BUILT))
    os.environ["RTGEN_CODEC"] = "c"  # an error if they are missing
    wanted = (
        ["fixed", "any of a string", "mutable"] if chosen.smallest else chosen.titles
    )
    peers = "in Python", "omniORBpy", "msgspec msgpack"
    columns = [(f"{name}, {way}", ".2f") for name in peers for way in WAYS]
    with (
        Results(__file__, chosen) as results,
        tempfile.TemporaryDirectory() as one,
        tempfile.TemporaryDirectory() as two,
    ):
        found = list(samples(*generated(Path(one))))
        load_omniorb(Path(two), FILES[0])
        ours = [(f"in C, {way} [ns]", ".0f") for way in WAYS]
        table = results.table("kinds", "value", *ours, *columns)
        for title, value in found:
            if wanted and title not in wanted:
                continue
            rows = {name: tasks for name, *tasks in candidates(value)}
            both = [
                dict(zip(rows, cdr.least_times([*tasks], chosen.rounds), strict=True))
                for tasks in zip(*rows.values(), strict=True)
            ]
            ratios = [
                times[name] / times["in C"] if name in times else None
                for name in peers
                for times in both
            ]
            table.add(title, *(times["in C"] for times in both), *ratios)


if __name__ == "__main__":
    main()
