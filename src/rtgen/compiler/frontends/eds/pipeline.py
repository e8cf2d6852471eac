"""The EDS front end: reads EDS, DCF, XDD and XDC files into devices and diagnostics."""

from __future__ import annotations

import re
from collections.abc import Sequence
from dataclasses import dataclass
from functools import lru_cache
from pathlib import Path, PurePath

import msgspec
from msgspec.structs import replace

from rtgen.compiler.diagnostics import Diagnostic, in_order
from rtgen.compiler.frontends import FrontendResult
from rtgen.compiler.frontends.eds import cob_ids, ini, keys, lists, xdd
from rtgen.compiler.frontends.eds.compact_pdo import implied
from rtgen.compiler.frontends.eds.findings import Findings
from rtgen.compiler.frontends.eds.information import Information
from rtgen.compiler.frontends.eds.modules import ModuleReader
from rtgen.compiler.frontends.eds.objects import ObjectReader
from rtgen.compiler.frontends.eds.outline import Outline, outline
from rtgen.compiler.frontends.eds.pdos import PdoReader
from rtgen.compiler.frontends.eds.rules import information as information_rules
from rtgen.compiler.frontends.eds.rules import lexical
from rtgen.compiler.frontends.kit.library import Library, absolute_path
from rtgen.compiler.frontends.kit.main_files import open_main
from rtgen.compiler.kit import stages
from rtgen.compiler.model import Model
from rtgen.compiler.model.canopen import (
    PDOS,
    RPDO_COMMUNICATION,
    TPDO_COMMUNICATION,
    Device,
    DeviceInfo,
    Object,
)
from rtgen.compiler.typemap.canopen.names import module_name
from rtgen.facts.device_files import XML_SUFFIXES, is_configured
from rtgen.facts.encodings import Encoded, digest

_ETHERNET_IP = re.compile(r"^\s*VendCode\s*=.*;", re.MULTILINE)
"""A key of section [Device] that each EDS of CIP has; its values end with a semicolon."""


def load(
    paths: Sequence[Path],
    *,
    root: Path,
    node_id: int | None = None,
    encoding: str = "auto",
) -> FrontendResult:
    """Read device descriptions into one model.

    `root` is the project's folder, to which keys of files are relative. `node_id` is the node-id of
    the devices, defaulting to that of a DCF; `encoding` that of files that do not tell theirs. All
    errors in the input are among the diagnostics, sorted; no exception is raised for them. A file
    with an error yields no device.
    """
    names = {absolute_path(path): path.as_posix() for path in reversed(paths)}
    run = _Run(Library(DescriptionFile, root, (), names), node_id, encoding)
    for absolute in dict.fromkeys(map(absolute_path, paths)):
        run.read(Path(absolute), names[absolute])
    return run.result()


@dataclass(frozen=True, slots=True, eq=False)
class DescriptionFile:
    """A description file with its bytes; `data` is None for a file that is too large."""

    name: str
    key: str
    path: Path
    data: bytes | None


class _Run(msgspec.Struct, eq=False):
    _library: Library[DescriptionFile]
    _node_id: int | None
    _encoding: str
    _devices: list[Device] = []
    _diagnostics: list[Diagnostic] = []
    _texts: dict[str, str] = {}

    def result(self) -> FrontendResult:
        return FrontendResult(
            model=Model(devices=tuple(self._devices)),
            diagnostics=tuple(in_order(self._diagnostics)),
            sources=self._texts,
            dependencies=self._library.dependencies,
        )

    def read(self, path: Path, name: str) -> None:
        stages.file(name)
        file = open_main(
            self._library,
            path,
            name,
            self._diagnostics.append,
            missing=lexical.MISSING_FILE,
            unreadable=lexical.UNREADABLE,
            beside="*.[edx][dc][sfdc]",
            apart=True,
        )
        if file is None:
            return
        if file.data is None:
            device, text = None, ""
            self._diagnostics.append(ini.too_large(file.name))
        else:
            data, encoding = file.data, self._encoding
            if isinstance(data, Encoded):
                encoding = data.encoding
            device, text, diagnostics = _read(
                data, file.name, file.key, self._node_id, encoding
            )
            self._diagnostics += diagnostics
        self._texts[file.name] = text
        self._devices += [device] if device is not None else []


@lru_cache(maxsize=32)  # bus files read device descriptions again
def _read(
    data: bytes, file: str, key: str, node_id: int | None, encoding: str
) -> tuple[Device | None, str, tuple[Diagnostic, ...]]:
    """Read a device (None if the description has errors), the text, and the diagnostics.

    `encoding` is the known or the asked one of a file without a byte-order mark. `file` is the path
    in diagnostics; its suffix tells the form (`facts.device_files`).
    """
    findings = Findings()
    if PurePath(file).suffix.lower() in XML_SUFFIXES:
        document = xdd.read(data, file, findings)
    else:
        document = ini.read(data, file, findings, encoding)
    if not document.inline and _ETHERNET_IP.search(document.text):
        findings = Findings()  # no line means what CiA 306 says
        message = "this is an EDS of EtherNet/IP (CIP), not of CANopen"
        hint = "the two formats have no more in common than the suffix"
        findings.add(lexical.NO_DEVICE, document.start, message, hint=hint)
    device = None if findings.failed else _described(document, findings, node_id)
    findings.rewrite(lambda diagnostic: _in_section(diagnostic, document))
    if device is not None:
        device = replace(device, key=key or file, sha256=digest(data))
    if findings.failed:
        device = None
    return device, document.text, findings.diagnostics


def _in_section(diagnostic: Diagnostic, document: ini.Document) -> Diagnostic:
    """Add the section of the line to a diagnostic."""
    assert diagnostic.span is not None
    name = document.section_at(diagnostic.span.line)
    if not name:
        return diagnostic
    return replace(diagnostic, message=f"{diagnostic.message} (in [{name}])")


def _described(
    document: ini.Document, findings: Findings, node_id: int | None
) -> Device | None:
    sections = outline(document, findings)
    lists.check_unknown(sections, findings)
    if not (sections.objects.heads or sections.objects.subs):
        message = "there is no object in this file"
        hint = "an EDS has sections such as [1000]"
        if document.inline:
            hint = "an XDD has a CANopenObject for each object"
        elif document.text.lstrip().startswith("<"):
            hint = "this is XML: call an XDD (CiA 311) *.xdd, an XDC *.xdc"
        findings.add(lexical.NO_DEVICE, document.start, message, hint=hint)
        return None
    keys.check(sections, findings)
    return _device(document, sections, findings, node_id)


def _device(
    document: ini.Document,
    sections: Outline,
    findings: Findings,
    node_id: int | None,
) -> Device:
    dcf = is_configured(PurePath(document.file))
    about = Information(document, sections, findings, dcf)
    about.check_sections()
    info = about.device_info()
    commissioning = about.commissioning()
    if node_id is None and commissioning is not None:
        node_id = commissioning.node_id
    objects = ObjectReader(sections.objects, findings, dcf).read()
    lists.check(document, sections, objects, findings)
    modules = ModuleReader(sections, findings, dcf)
    kinds, connected = modules.kinds(), modules.connected()
    objects = modules.apply(objects, connected)
    indices = {o.index for o in objects}
    objects += implied(info, indices, document.start)
    objects.sort(key=lambda o: o.index)
    dummies = about.dummies()
    cob_ids.check(objects, node_id, findings)
    pdos = PdoReader(objects, info, dummies, node_id, findings).read()
    device = Device(
        name=module_name(Path(document.file).stem),
        file=document.file,
        key=document.file,
        sha256="",
        span=document.start,
        node_id=node_id,
        file_info=about.file_info(),
        info=info,
        commissioning=commissioning,
        objects=tuple(objects),
        pdos=pdos,
        dummies=dummies,
        comments=about.comments(),
        modules=kinds,
        connected=connected,
        further=tuple(
            (s.name, tuple((e.key, e.value) for e in s.entries.values()))
            for s in sections.further
        ),
    )
    _check_counts(info, objects, sections, findings)
    _check_identity(device, sections, findings)
    return device


def _check_counts(
    info: DeviceInfo, objects: Sequence[Object], sections: Outline, findings: Findings
) -> None:
    section = sections.plain.get("deviceinfo")
    for key, declared, base in (
        ("NrOfRXPDO", info.rpdos, RPDO_COMMUNICATION),
        ("NrOfTXPDO", info.tpdos, TPDO_COMMUNICATION),
    ):
        count = sum(base <= o.index < base + PDOS for o in objects)
        entry = None if section is None else section.get(key)
        if entry is not None and declared is not None and declared != count:
            message = f"{key} is {declared}; {count} are described"
            findings.add(information_rules.PDO_COUNT, entry.span, message)


def _check_identity(device: Device, sections: Outline, findings: Findings) -> None:
    section = sections.plain.get("deviceinfo")
    for key, declared, subindex in (
        ("VendorNumber", device.info.vendor_number, 1),
        ("ProductNumber", device.info.product_number, 2),
    ):
        variable = device.find(0x1018, subindex)
        other = None if variable is None else variable.current
        entry = None if section is None else section.get(key)
        if entry is not None and declared and other and declared != other:
            message = (
                f"{key} is 0x{declared:X}, but 1018h sub-index {subindex} is another"
            )
            findings.add(information_rules.OTHER_IDENTITY, entry.span, message)
