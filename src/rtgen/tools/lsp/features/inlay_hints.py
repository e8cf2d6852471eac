"""Inlay hints: wire offsets of struct members, and of objects in PDOs."""

from __future__ import annotations

from collections.abc import Iterator

from lsprotocol.types import InlayHint, Range

from rtgen.compiler.model import Struct
from rtgen.compiler.model.canopen import Device, PdoEntry
from rtgen.tools.indexing.index import Kind, path_of
from rtgen.tools.lsp.documents import Language
from rtgen.tools.lsp.features.describe import find, layout_of_struct, place_text
from rtgen.tools.lsp.workspace import View


def inlay_hints(view: View, range_: Range) -> list[InlayHint]:
    """Return the hints in a range."""
    low, high = view.offset(range_.start), view.offset(range_.end)
    structs = view.language is Language.IDL
    hints = _of_structs(view, low, high) if structs else _of_pdos(view)
    return [
        InlayHint(view.range(end, end).start, label, padding_left=True)
        for end, label in hints
        if low <= end <= high
    ]


def _of_structs(view: View, low: int, high: int) -> Iterator[tuple[int, str]]:
    if view.analysis is None:
        return
    places: dict[str, dict[str, str]] = {}
    for _, end, _, _, d in view.definitions():
        if d.kind is not Kind.MEMBER or not low <= end <= high:
            continue
        if d.container not in places:
            name = tuple(d.container.removeprefix("idl ").split("::"))
            struct = find(view.analysis.model, name)
            laid_out = (
                layout_of_struct(view.analysis, struct)
                if isinstance(struct, Struct)
                else ()
            )
            places[d.container] = {
                place.member.name: place_text(place)
                for place in laid_out
                if place.holder is struct and place.offset is not None
            }
        label = places[d.container].get(d.name)
        if label is not None:
            yield end, label


def _of_pdos(view: View) -> Iterator[tuple[int, str]]:
    """Yield a hint after each entry of a PDO mapping: the object, its first bit and length."""
    if view.analysis is None or view.file is None:
        return
    if view.language not in (Language.EDS, Language.XDD):
        return
    shift = view.shift
    for device in view.analysis.model.devices:
        if path_of(device.file) != view.document.path:
            continue
        for pdo in device.pdos:
            for number, (offset, entry) in enumerate(pdo.places, 1):
                variable = device.find(pdo.mapping, number)
                if variable is not None and variable.value_span != variable.span:
                    place = view.file.text.offsets(variable.value_span)
                    moved = shift.forward(*place)
                    if moved is not None:
                        yield moved[1], _label(device, entry, offset)


def _label(device: Device, entry: PdoEntry, offset: int) -> str:
    variable = device.find(entry.index, entry.subindex)
    name = "gap" if variable is None else variable.name
    return f"{name}: bit {offset}, {entry.bits} bits"
