"""Converts a description of a device to EDS, DCF, XDD or XDC, and lists what was changed."""

from __future__ import annotations

from pathlib import Path

from msgspec.structs import replace

from rtgen.compiler.diagnostics import has_errors, in_order
from rtgen.compiler.model.canopen import Commissioning, Device, FileInfo
from rtgen.facts.device_files import (
    DEVICE_SUFFIXES,
    XML_SUFFIXES,
    is_configured,
    is_device_file,
)
from rtgen.facts.files import read_file
from rtgen.facts.version import __version__
from rtgen.tools.can.descriptions.changes import changes
from rtgen.tools.can.descriptions.completion import completed
from rtgen.tools.components.conversion import Converted, require_form
from rtgen.tools.kit.console import Console
from rtgen.tools.kit.exits import BAD_INPUT, Refusal, ReportedError

OF_DEVICES = tuple(suffix[1:] for suffix in DEVICE_SUFFIXES)
_OTHERS = {"eds": "xdd", "dcf": "xdc", "xdd": "eds", "xdc": "dcf"}
_XML = tuple(suffix[1:] for suffix in XML_SUFFIXES)


def converted_device(
    console: Console, path: Path, form: str | None, node_id: int | None
) -> Converted:
    """Return the description of a device in a form, by default the other one of the same kind.

    `node_id` is that of a DCF or XDC. What was changed is reported. Raises InputError, Refusal,
    ReportedError.
    """
    from rtgen.compiler.frontends import eds

    form = form or _OTHERS[path.suffix.lower()[1:]]
    require_form(form, OF_DEVICES, "a description of a device")
    target = path.with_suffix(f".{form}")
    if node_id is not None and not is_configured(target):
        raise Refusal("--node-id is of a DCF or XDC: --to dcf, --to xdc")
    read = eds.load([path], root=Path.cwd(), node_id=node_id)
    if not read.model.devices or has_errors(read.diagnostics):
        console.findings(read.diagnostics, read.sources)
        raise ReportedError(BAD_INPUT)
    device, added = completed(read.model.devices[0], in_xml=form in _XML)
    device = _named(_as_configured(device, is_configured(target), node_id), target)
    text = written(device, form, f"Written by rtgen {__version__} from {path.name}.")
    notes = changes(path, read_file(path), read.diagnostics, target, text)
    found = [*notes.unexplained, *added, *notes.changes]
    console.findings(in_order(found), read.sources, fold=False)
    return Converted(target.name, text)


def written(device: Device, form: str, comment: str) -> str:
    """Return the text of a description in a form, for all readers."""
    if form in _XML:
        from rtgen.compiler.backends.canopen.xdd_text import xdd_text

        return xdd_text(device, [comment])
    from rtgen.compiler.backends.canopen.eds_text import eds_text

    return eds_text(device, [comment], portable=True)


def _as_configured(device: Device, configured: bool, node_id: int | None) -> Device:
    """Return a device with a commissioning, or without one and without configured values."""
    if configured:
        commissioning = device.commissioning or Commissioning()
        if node_id is not None:
            commissioning = replace(commissioning, node_id=node_id)
        return replace(device, commissioning=commissioning)
    objects = tuple(
        replace(
            thing,
            denotation="",
            variables=tuple(
                replace(v, value=None, denotation="", upload_file="", download_file="")
                for v in thing.variables
            ),
        )
        for thing in device.objects
    )
    return replace(device, objects=objects, commissioning=None)


def _named(device: Device, target: Path) -> Device:
    """Return a device with the name of its file in the new form."""
    info: FileInfo = device.file_info
    name = Path(info.file_name)
    if name.name and is_device_file(name):
        info = replace(info, file_name=name.with_suffix(target.suffix).as_posix())
    return replace(device, file_info=info)
