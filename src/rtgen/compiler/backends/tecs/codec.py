"""The codec modules of a package: requests and replies of its signatures, in both directions.

Functions with equal messages share one class. A class is defined in the module of the signature
that uses it; one that several signatures use, in `_messages.py`.
"""

from __future__ import annotations

import re
from collections.abc import Iterable, Sequence

from msgspec.structs import replace

from rtgen.compiler.backends.kit.python_text import fit_text
from rtgen.compiler.backends.kit.quoting.python import string_literal
from rtgen.compiler.backends.kit.rendering import render
from rtgen.compiler.backends.tecs.codec_classes import (
    CodecClass,
    FunctionCodec,
    record_codec,
)
from rtgen.compiler.backends.tecs.function_text import function_names
from rtgen.compiler.layouts.signature_digest import signature_digest
from rtgen.compiler.layouts.tdr import SignatureLayout
from rtgen.compiler.layouts.tdr_messages import layout_of
from rtgen.compiler.model.graphs import reached
from rtgen.compiler.model.tecs import Signature, TecsFunction, TecsUnit
from rtgen.compiler.typemap.python.names import identifier
from rtgen.compiler.typemap.tecs.python import (
    CODEC_IMPORTS,
    IMPORTED_NAMES,
    codec_class,
    codec_module,
    struct_class,
)

SHARED = "_messages"
"""The module of the classes that several signatures use."""


def codec_text(
    unit: TecsUnit, signature: Signature, header: str, order: str = "tecsgen"
) -> str:
    """Return the self-contained codec module of one signature. Raises TransferError."""
    (text,) = codec_texts(unit, [(layout_of(unit, signature), order)], header).values()
    return text


class _Signature:
    """The classes of a signature, and the class of each function."""

    def __init__(
        self, layout: SignatureLayout, order: str, known: dict[object, CodecClass]
    ) -> None:
        self.layout = layout
        self.name = codec_class(layout.signature)
        self.structs = [struct_class(record.struct.name) for record in layout.records]
        self.records = {
            made.name: made
            for record in layout.records
            if not record.fixed
            for made in [record_codec(record, self.structs)]
        }
        self.functions = []
        for function in layout.functions:
            key = (order, tuple(self.structs), *_declaration(function.function))
            if key not in known:
                known[key] = FunctionCodec(function, self.structs, order).codec_class()
            self.functions.append(known[key])


def _declaration(function: TecsFunction) -> tuple[object, ...]:
    """Return the declaration on which a function's messages depend."""
    parameters = ((p.name, p.type, p.direction, p.sizes) for p in function.parameters)
    return function.oneway, function.returns, *parameters


def codec_texts(
    unit: TecsUnit, layouts: Iterable[tuple[SignatureLayout, str]], header: str
) -> dict[str, str]:
    """Return the codec modules of a package by file name; `header` is their comment.

    Each layout comes with the order of replies: `tecsgen` sends the return value before the outs,
    `paper` after them. The modules import the structs' classes from `_types` beside them.
    """
    known: dict[object, CodecClass] = {}
    signatures = [_Signature(layout, order, known) for layout, order in layouts]
    classes, users = _named(signatures)
    shared = reached(
        (name for name, modules in users.items() if len(modules) > 1),
        lambda name: classes[name].records,
    )
    structs = {name for signature in signatures for name in signature.structs}
    texts = {}
    if shared:
        doc = '"""Messages that functions of several signatures have."""'
        own = [made.text for name, made in classes.items() if name in shared]
        body = "\n\n\n".join(own) + "\n"
        texts[f"{SHARED}.py"] = _module(header, doc, body, structs, ())
    for signature in signatures:
        scoped = signature.layout.signature.scoped
        own = [
            made.text
            for name, made in classes.items()
            if name not in shared and users[name] == {scoped}
        ]
        names = function_names(signature.layout)
        body = render(
            "tecs/codec.py.j2",
            name=signature.name,
            scoped=scoped,
            scoped_literal=string_literal(scoped),
            digest=signature_digest(unit, signature.layout.signature),
            classes=own,
            functions=[
                (names[f.function.name], made.name, string_literal(f.function.name), f)
                for f, made in zip(
                    signature.layout.functions, signature.functions, strict=True
                )
            ],
        )
        doc = f'"""The messages of `{scoped}`."""'
        texts[f"{codec_module(signature.layout.signature)}.py"] = _module(
            header, doc, body, structs, shared
        )
    return texts


def _named(
    signatures: Sequence[_Signature],
) -> tuple[dict[str, CodecClass], dict[str, set[str]]]:
    """Return all classes by their name, and the signatures that use each.

    Classes that differ only in their name are merged.
    """
    taken = {name for signature in signatures for name in signature.structs}
    taken |= IMPORTED_NAMES
    taken |= {signature.name for signature in signatures}
    classes: dict[str, CodecClass] = {}
    users: dict[str, set[str]] = {}
    unnamed: dict[CodecClass, CodecClass] = {}

    def use(name: str, scoped: str) -> None:
        users.setdefault(name, set()).add(scoped)
        for record in classes[name].records:
            use(record, scoped)

    for signature in signatures:
        for record in signature.records.values():
            classes.setdefault(record.name, record)
            taken.add(record.name)
    for signature in signatures:
        scoped = signature.layout.signature.scoped
        for index, made in enumerate(signature.functions):
            known = unnamed.get(replace(made, name=""))
            if known is None:
                known = replace(made, name=identifier(made.name, taken))
                taken.add(known.name)
                classes[known.name] = unnamed[replace(made, name="")] = known
            signature.functions[index] = known
            use(known.name, scoped)
    used = {name: made for name, made in classes.items() if name in users}
    return used, users


def _module(
    header: str, doc: str, body: str, structs: Iterable[str], shared: Iterable[str]
) -> str:
    words = set(re.findall(r"\w+", body))

    def used(names: Iterable[str]) -> list[str]:
        return sorted(name for name in names if name in words)

    lines = [doc, "", "from __future__ import annotations", ""]
    if "Sequence" in words:
        lines += ["from collections.abc import Sequence", ""]
    if "ClassVar" in words:
        lines += ["from typing import ClassVar", ""]
    for module, imported in CODEC_IMPORTS.items():
        if names := used(imported):
            lines.append(
                f"from rtgen.runtime.opaque_rpc.{module} import {', '.join(names)}"
            )
    local = ((f".{SHARED}", used(shared)), ("._types", used(structs)))
    beside = [f"from {m} import {', '.join(n)}" for m, n in local if n]
    lines += ["", *beside] if beside else []
    return fit_text("\n".join([header.rstrip("\n"), *lines, "", "", body]).lstrip("\n"))
