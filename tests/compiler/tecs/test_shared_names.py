"""Signatures and structs with names that the modules of a board bind themselves.

Interface, bases of RTCs, proxy and marshaller are in one module, structs and their conversions in
another; whatever the name of a definition, each name must have one meaning in each module.
"""

from __future__ import annotations

import builtins
import inspect
from pathlib import Path
from types import ModuleType
from typing import Any, get_type_hints

import pytest
from boards import emit, imported, joined, write

from rtgen.compiler.typemap.python.names import module_name
from rtgen.compiler.typemap.python.support import BASE_NAMES, HOMES
from rtgen.compiler.typemap.tecs.python import MARSHALLER_NAMES
from rtgen.runtime import Servant, Skeleton, Stub

BOUND = sorted(
    {*BASE_NAMES, *HOMES, *MARSHALLER_NAMES, "codec_One", "idl_One"}
    - {*dir(builtins), "OpaqueRpc"}
)
"""Names that these modules import or define, if they are valid in CDL."""


def text_of(signature: str, struct: str) -> str:
    return joined(
        f"struct {struct} {{ int32_t a; int8_t b; }};\n"
        f"signature {signature} {{\n"
        f"  ER send( [in] const struct {struct} *given, [out] struct {struct} *back );\n"
        "  ER many( [in,size_is(n)] const double64_t *list, [in] int32_t n );\n"
        "};\n",
        signature,
    )


def check(made: ModuleType, name: str, server: ModuleType) -> None:
    """Check that annotations refer to the right types, and that the marshaller can be created."""
    component = getattr(made, f"{name}Marshaller")("M0")
    assert component.profile.type_name == f"{name}Marshaller"
    proxy = getattr(made, f"{name}Proxy")
    assert issubclass(proxy, getattr(server, f"{name}Target"))
    interface = next(p.interface for p in component.providers.values())
    assert issubclass(interface, Servant)
    own = [
        c for c in vars(made).values() if getattr(c, "__module__", "") == made.__name__
    ]
    classes = [c for c in own if isinstance(c, type)]
    assert (
        len([c for c in classes if issubclass(c, Stub) and issubclass(c, interface)])
        == 1
    )
    assert len([c for c in classes if issubclass(c, Skeleton)]) == 1
    for each in classes:
        for function in vars(each).values():
            if inspect.isfunction(function):
                get_type_hints(function)
    of_cdl: Any = get_type_hints(proxy.send)["given"]
    of_idl: Any = get_type_hints(interface.send)["given"]
    assert of_cdl.__module__.endswith("._types")
    assert of_idl.__module__.endswith("._views")
    assert of_idl._descriptor_.name.lower().startswith(
        of_cdl.__name__.lower().rstrip("_")
    )


@pytest.mark.sampled(6)
@pytest.mark.parametrize("corba", [False, True], ids=["embedded", "corba"])
@pytest.mark.parametrize("name", BOUND)
def test_a_signature_and_a_struct_of_a_bound_name(
    name: str, corba: bool, tmp_path: Path
) -> None:
    files = {
        "signed.cdl": text_of(name, "One"),
        "built.cdl": text_of("sThing", name),
    }
    emission, findings = emit(tmp_path, files, corba=corba)
    assert not findings
    write(tmp_path, emission.artifacts)
    stem = module_name(name)
    with imported(
        tmp_path,
        f"robots.tecs.signed.{stem}_marshaller",
        f"robots.tecs.signed.{stem}_server",
        "robots.tecs.built.thing_marshaller",
        "robots.tecs.built.thing_server",
    ) as (signed, signed_server, built, built_server):
        check(signed, name, signed_server)
        check(built, "Thing", built_server)


@pytest.mark.parametrize("made", ["Stub", "Skeleton"])
def test_a_struct_is_called_as_what_is_made_of_the_signature(
    made: str, tmp_path: Path
) -> None:
    emission, findings = emit(tmp_path, {"a.cdl": text_of("sThing", f"Thing{made}")})
    assert not findings
    write(tmp_path, emission.artifacts)
    names = ("robots.tecs.a.thing_marshaller", "robots.tecs.a.thing_server")
    with imported(tmp_path, *names) as (module, server):
        check(module, "Thing", server)


def test_a_struct_is_called_as_the_interface(tmp_path: Path) -> None:
    emission, findings = emit(tmp_path, {"a.cdl": text_of("sThing", "Thing")})
    assert not findings
    write(tmp_path, emission.artifacts)
    names = ("robots.tecs.a.thing_marshaller", "robots.tecs.a.thing_server")
    with imported(tmp_path, *names, "robots.tecs.a") as (module, server, package):
        check(module, "Thing", server)
        component = module.ThingMarshaller("M0")
        [provider] = component.providers.values()
        assert package.Thing is provider.interface
