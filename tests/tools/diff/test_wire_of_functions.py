"""Random changes of TECS signatures: `rtgen diff` agrees with the codecs about TDR and ids."""

from __future__ import annotations

import sys
from collections.abc import Callable, Iterator, Sequence
from pathlib import Path
from random import Random

import seeds
from hypothesis import HealthCheck, Phase, given, seed, settings
from hypothesis import strategies as st
from msgspec.structs import replace

sys.path.insert(0, str(Path(__file__).parents[2] / "compiler" / "tecs"))

from random_signatures import Call, Sample, plain, sample

from rtgen.compiler.layouts.tdr import TransferError, references
from rtgen.compiler.model import Model
from rtgen.compiler.model.c_types import CArrayType, CPointerType, CScalarType
from rtgen.compiler.model.tecs import (
    Signature,
    Sizes,
    TecsDirection,
    TecsFunction,
    TecsParameter,
    TecsUnit,
)
from rtgen.facts.tdr import Scalar
from rtgen.runtime.opaque_rpc import RpcError, make_tdr
from rtgen.tools.diff.changes import Change, Wire
from rtgen.tools.diff.signatures import compare_signatures
from rtgen.tools.diff.versions import Version
from rtgen.tools.rpc.codecs import Function, Service

MAX_WITNESSES = 60
TDRS = (
    make_tdr("network"),
    make_tdr("network", short_bits=32, int_bits=64, long_bits=64, intptr_bits=64),
)
"""Breaks may occur only for other widths of `short`, `int`, `long` and `intptr_t`."""
_OTHER = {
    Scalar.INT8: Scalar.UINT8,
    Scalar.UINT8: Scalar.INT16,
    Scalar.INT16: Scalar.UINT16,
    Scalar.INT32: Scalar.UINT32,
    Scalar.INT64: Scalar.DOUBLE64,
    Scalar.BOOL: Scalar.INT8,
    Scalar.FLOAT32: Scalar.INT32,
    Scalar.CHAR: Scalar.UCHAR,
}

Changer = Callable[[Random, list[TecsFunction]], None]


def _sized(function: TecsFunction) -> set[str]:
    """Return the parameters that sizes refer to."""
    sizes = (
        e
        for p in function.parameters
        for e in (p.sizes.size_is, p.sizes.count_is, p.sizes.string)
    )
    return {name for each in sizes for name in references(each)}


def _free(function: TecsFunction) -> list[TecsParameter]:
    """Return the parameters without sizes that no size refers to."""
    used = _sized(function)
    return [p for p in function.parameters if p.name not in used and p.sizes == Sizes()]


def _with(
    functions: list[TecsFunction], place: int, parameters: Sequence[TecsParameter]
) -> None:
    functions[place] = replace(functions[place], parameters=tuple(parameters))


def _rename(random: Random, functions: list[TecsFunction]) -> None:
    place = random.randrange(len(functions))
    if free := _free(functions[place]):
        chosen = random.choice(free)
        _with(
            functions,
            place,
            [
                replace(p, name="renamed") if p is chosen else p
                for p in functions[place].parameters
            ],
        )


def _drop(random: Random, functions: list[TecsFunction]) -> None:
    place = random.randrange(len(functions))
    if free := _free(functions[place]):
        chosen = random.choice(free)
        _with(
            functions,
            place,
            [p for p in functions[place].parameters if p is not chosen],
        )


def _retype(random: Random, functions: list[TecsFunction]) -> None:
    place = random.randrange(len(functions))
    scalars = [
        p
        for p in _free(functions[place])
        if isinstance(p.type, CScalarType) and p.type.kind in _OTHER
    ]
    if scalars:
        chosen = random.choice(scalars)
        assert isinstance(chosen.type, CScalarType)
        type_ = CScalarType(_OTHER[chosen.type.kind])
        _with(
            functions,
            place,
            [
                replace(p, type=type_) if p is chosen else p
                for p in functions[place].parameters
            ],
        )


def _nullable(random: Random, functions: list[TecsFunction]) -> None:
    place = random.randrange(len(functions))
    pointers = [
        p
        for p in _free(functions[place])
        if isinstance(p.type, CPointerType)
        and p.direction in (TecsDirection.IN, TecsDirection.INOUT)
        and p.type.target != CScalarType(Scalar.VOID)
    ]
    if pointers:
        chosen = random.choice(pointers)
        sizes = Sizes(nullable=True)
        _with(
            functions,
            place,
            [
                replace(p, sizes=sizes) if p is chosen else p
                for p in functions[place].parameters
            ],
        )


def _swap(random: Random, functions: list[TecsFunction]) -> None:
    random.shuffle(functions)


def _insert(random: Random, functions: list[TecsFunction]) -> None:
    made = replace(functions[0], name="added", parameters=(), oneway=False)
    functions.insert(random.randint(0, len(functions)), made)


def _remove(random: Random, functions: list[TecsFunction]) -> None:
    functions.pop(random.randrange(len(functions)))


def _returns(random: Random, functions: list[TecsFunction]) -> None:
    place = random.randrange(len(functions))
    if not functions[place].oneway:
        functions[place] = replace(functions[place], returns=CScalarType(Scalar.INT16))


def _array(random: Random, functions: list[TecsFunction]) -> None:
    place = random.randrange(len(functions))
    arrays = [p for p in _free(functions[place]) if isinstance(p.type, CArrayType)]
    if arrays:
        chosen = random.choice(arrays)
        assert isinstance(chosen.type, CArrayType)
        type_ = CArrayType(chosen.type.element, (chosen.type.size or 0) + 1)
        _with(
            functions,
            place,
            [
                replace(p, type=type_) if p is chosen else p
                for p in functions[place].parameters
            ],
        )


CHANGERS: tuple[Changer, ...] = (
    *(_rename, _drop, _retype, _nullable, _swap, _insert, _remove, _returns, _array),
)


def changed(found: Sample, random: Random) -> tuple[TecsUnit, Signature]:
    """Return the signature with a change or two, and new ids."""
    functions = list(found.signature.functions)
    for _ in range(random.choice((1, 1, 2))):
        random.choice(CHANGERS)(random, functions)
    numbered = tuple(replace(f, id=i) for i, f in enumerate(functions, 1))
    signature = replace(found.signature, functions=numbered)
    declared = tuple(d for d in found.unit.declarations if d is not found.signature)
    return replace(found.unit, declarations=(*declared, signature)), signature


def _same(read: object, written: object) -> bool:
    """Return whether values and their types are equal: a truth value is not a number."""
    return repr(plain(read)) == repr(plain(written))


def readings(
    old: Function, new: Function, calls: Iterator[Call]
) -> Iterator[tuple[bool, object]]:
    """Yield whether messages of one version are read as equal by the other, and written equal."""
    for call in calls:
        values = tuple(call.args[item.name] for item in old.layout.arguments)
        request = old.encode_request(values)
        try:
            read = new.decode_request(request)
        except RpcError as error:
            yield False, (values, error)
            continue
        yield _same(read, values), (values, read)
        if old.oneway or new.oneway:
            yield old.oneway == new.oneway, "oneway"
            continue
        kept = old.kept(values)
        outs = tuple(call.outs[item.name] for item in old.layout.outs)
        reply = old.encode_reply(kept, call.returned, outs)
        try:
            returned, results = new.decode_reply(reply, new.kept(read))
            before = old.decode_reply(reply, kept)
        except (RpcError, KeyError, ValueError) as error:
            yield False, (reply, error)
            continue
        yield _same((returned, results), before), (reply, returned, results)


def _breaks(changes: Sequence[Change], function: str) -> bool:
    own = f"sRandom.{function}"
    return any(
        {Wire.TDR, Wire.FUNCTION_ID} & {*c.wires}
        and (c.subject == own or c.subject.startswith(f"{own}("))
        for c in changes
    )


def _calls(
    found: Sample, random: Random, service: Service, name: str, count: int
) -> Iterator[Call]:
    function = service.functions[name].layout.function
    return (found.call(random, function, service.types) for _ in range(count))


@settings(
    deadline=None,
    database=None,
    phases=[Phase.generate],
    suppress_health_check=list(HealthCheck),
    max_examples=seeds.budget(60),
)
@seed(seeds.seed())
@given(random=st.integers(0, 1 << 32).map(Random))
def test_tdr_is_as_diff_says(random: Random) -> None:
    found = sample(random)
    unit, signature = changed(found, random)
    versions = [Version(Model(tecs=(each,))) for each in (found.unit, unit)]
    changes = [*compare_signatures(*versions)]
    try:
        services = [
            (Service(found.unit, found.signature, tdr), Service(unit, signature, tdr))
            for tdr in TDRS
        ]
    except TransferError:
        return  # no OpaqueRPC for a signature that cannot be transferred
    old, new = services[0]
    for name in old.functions.keys() & new.functions.keys():
        broken = _breaks(changes, name)
        count = MAX_WITNESSES if broken else 5
        compared = (
            reading
            for one, other in services
            for reading in readings(
                one.functions[name],
                other.functions[name],
                _calls(found, random, one, name, count),
            )
        )
        if broken:
            assert any(not same for same, _ in compared), (name, changes)
        else:
            for same, values in compared:
                assert same, (name, values, changes)
    gone = old.functions.keys() - new.functions.keys()
    for name in gone:
        removed = [c for c in changes if c.subject == f"sRandom.{name}"]
        called = [c for c in changes if f"was called {name}" in c.message]
        assert removed or called


def test_a_service_of_each_version_is_made() -> None:
    """Each of the changes above leaves a signature that can be transferred."""
    for number, change in enumerate(CHANGERS):
        random = Random(number)
        functions = list(sample(random).signature.functions)
        change(random, functions)
        assert functions
