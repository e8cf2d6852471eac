"""`OpaqueRpc` of the runtime equals the code generated from its IDL file, in types and octets."""

from __future__ import annotations

import importlib
import sys
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pytest

from rtgen.compiler.backends import Options
from rtgen.compiler.backends.types.backend import BACKEND
from rtgen.compiler.frontends import idl
from rtgen.compiler.lowering.tecs.communication import communication_model
from rtgen.compiler.model import Component, Interface, Model, SourceFile
from rtgen.runtime.marshalling.comparison import difference
from rtgen.runtime.opaque_rpc import OpaqueRpc
from rtgen.runtime.opaque_rpc.communication import OpaqueRpcCommunication
from rtgen.runtime.opaque_rpc.interface import IDL, OCTETS
from rtgen.runtime.services.calls import Client, Server, calls_of
from rtgen.runtime.services.servants import operations_of

PACKAGE = "opaque_rpc_of_idl"


@pytest.fixture(scope="module")
def read() -> Model:
    found = idl.load([IDL], root=IDL.parent)
    assert not found.diagnostics
    return found.model


@pytest.fixture(scope="module")
def made(read: Model, tmp_path_factory: pytest.TempPathFactory) -> Iterator[Any]:
    """Import the code generated from the IDL file."""
    folder = tmp_path_factory.mktemp("made")
    for artifact in BACKEND.emit(read, Options(PACKAGE, "", "0.1.0")).artifacts:
        file = folder / artifact.path
        file.parent.mkdir(parents=True, exist_ok=True)
        file.write_text(artifact.text, encoding="utf-8")
    sys.path.insert(0, str(folder))
    yield importlib.import_module(PACKAGE).OpaqueRpc
    sys.path.remove(str(folder))
    for name in [n for n in sys.modules if n.partition(".")[0] == PACKAGE]:
        del sys.modules[name]


def test_the_compilers_model_is_that_of_the_file(read: Model) -> None:
    source = SourceFile(name="a.cdl", key="a.cdl", sha256="0" * 64, main=True)
    model = communication_model((source,))
    known = {d.name: d for d in model.declarations if not isinstance(d, Component)}
    assert known.keys() == {d.name for d in read.declarations}
    for declaration in read.declarations:
        ours: Any = known[declaration.name]
        assert (type(ours), ours.repository_id, ours.doc) == (
            type(declaration),
            declaration.repository_id,
            declaration.doc,
        )
        if isinstance(declaration, Interface):
            pairs = zip(ours.operations, declaration.operations, strict=True)
            for one, other in pairs:
                assert (one.name, one.returns, one.raises, one.doc) == (
                    other.name,
                    other.returns,
                    other.raises,
                    other.doc,
                )
                assert [(p.direction, p.name, p.type) for p in one.parameters] == [
                    (p.direction, p.name, p.type) for p in other.parameters
                ]


def test_the_descriptors(made: Any) -> None:
    assert difference(OpaqueRpc._descriptor_, made._descriptor_) is None
    assert OpaqueRpc._descriptor_ == made._descriptor_
    assert OpaqueRpc.Failed._descriptor_ == made.Failed._descriptor_
    assert made.OctetsCodec._descriptor_ == OCTETS
    ours, theirs = operations_of(OpaqueRpc), operations_of(made)
    assert [(n, o.python_name, o.count, o.oneway) for n, o in ours.items()] == [
        (n, o.python_name, o.count, o.oneway) for n, o in theirs.items()
    ]
    for name, operation in ours.items():
        raises = [e._descriptor_ for e in theirs[name].raises]  # type: ignore[attr-defined]
        assert [e._descriptor_ for e in operation.raises] == raises  # type: ignore[attr-defined]


@pytest.mark.parametrize("little_endian", [True, False])
def test_the_octets_of_calls(made: Any, little_endian: bool) -> None:
    ours, theirs = calls_of(OpaqueRpc), calls_of(made)
    assert ours.keys() == theirs.keys()
    values: dict[str, list[tuple[Any, ...]]] = {
        "begin": [(b"", 0), (bytes(range(7)), 2**32 - 1)],
        "more": [(5,)],
    }
    for name, call in ours.items():
        other = theirs[name]
        for body, its, given in (
            (call.request, other.request, values.get(name, [])),
            (call.reply, other.reply, [(b"",), (b"abcde",)]),
        ):
            assert (body is None) == (its is None)
            for each in given if body is not None and its is not None else ():
                octets = body(*each).to_cdr(little_endian)
                assert octets == its(*each).to_cdr(little_endian)
                assert body.from_cdr(octets, little_endian) == body(*each)
        assert len(call.raises) == len(other.raises)
        for (body, _), (its, _) in zip(call.raises, other.raises, strict=True):
            each = ("IDL:OpaqueRpc/Failed:1.0", -50, "no answer")
            octets = body(*each).to_cdr(little_endian)
            assert octets == its(*each).to_cdr(little_endian)
            assert body.from_cdr(octets, little_endian) == body(*each)


def test_calls_between_the_two(made: Any) -> None:
    class Servant(OpaqueRpc):
        def begin(self, request: bytes, first: int) -> bytes:
            raise OpaqueRpc.Failed(first, request.decode())

        def more(self, count: int) -> bytes:
            return bytes(count)

        def end(self) -> None: ...

        def reset(self) -> None: ...

    server = Server(OpaqueRpc, Servant())
    stub = made._stub_(Client(made, lambda name, body, _: server.handle(name, body)))
    assert stub.more(3) == b"\0\0\0"
    assert stub.end() is None
    with pytest.raises(made.Failed) as failed:
        stub.begin(b"why", 7)
    assert (failed.value.code, failed.value.reason) == (7, "why")


def test_parameters_have_the_defaults_of_the_profile() -> None:
    component = OpaqueRpcCommunication("Communication0")
    for parameter in component.profile.configuration:
        value = getattr(component.config, parameter.python_name)
        assert str(value) == parameter.default
    assert Path(IDL).name == "OpaqueRpc.idl"
