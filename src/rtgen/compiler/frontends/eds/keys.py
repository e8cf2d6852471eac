"""The known keys of each kind of section (CiA 306), and a check for unknown ones."""

from __future__ import annotations

import re
from difflib import get_close_matches

from rtgen.compiler.frontends.eds.findings import Findings
from rtgen.compiler.frontends.eds.ini import Section
from rtgen.compiler.frontends.eds.outline import COMMISSIONING, LISTS, Outline
from rtgen.compiler.frontends.eds.rules import lexical

_MAX_SUGGESTIONS = 100


class _Keys:
    """The keys of one kind of section: fixed names, and a pattern for numbered ones."""

    def __init__(self, names: str, pattern: str = "(?!)") -> None:
        self.names = {name.lower(): name for name in names.split()}
        self.pattern = re.compile(pattern)


_OBJECT = _Keys(
    "ParameterName ObjectType SubNumber DataType AccessType PDOMapping LowLimit HighLimit "
    "DefaultValue ObjFlags CompactSubObj ParameterValue Denotation UploadFile DownloadFile "
    "ParamRefd UniqueIDRef StorageLocation Factor Unit Description"
)
_EXTENSION = _Keys(" ".join([*_OBJECT.names.values(), "Count", "ObjExtend"]))
_LIST = _Keys("SupportedObjects", "[0-9]+")
_ENTRIES = _Keys("NrOfEntries", "[0-9]+")
_PLAIN = {
    "fileinfo": _Keys(
        "FileName FileVersion FileRevision EDSVersion Description CreationTime CreationDate "
        "CreatedBy ModificationTime ModificationDate ModifiedBy LastEDS"
    ),
    "deviceinfo": _Keys(
        "VendorName VendorNumber ProductName ProductNumber RevisionNumber OrderCode "
        "SimpleBootUpMaster SimpleBootUpSlave Granularity DynamicChannelsSupported CompactPDO "
        "GroupMessaging NrOfRXPDO NrOfTXPDO LSS_Supported NG_Slave NG_Master NrOfNG_MonitoredNodes",
        "baudrate_[0-9]+",
    ),
    COMMISSIONING: _Keys(
        "NodeID NodeName NodeRefd Baudrate NetNumber NetworkName NetRefd CANopenManager "
        "LSS_SerialNumber"
    ),
    "dummyusage": _Keys("", "dummy[0-9a-f]{4}"),
    "comments": _Keys("Lines", "line[0-9]+"),
    **dict.fromkeys(LISTS, _LIST),
    "supportedmodules": _ENTRIES,
    "connectedmodules": _ENTRIES,
}


def check(outline: Outline, findings: Findings) -> None:
    """Report unknown keys."""
    checker = _Checker(findings)
    for name, section in outline.plain.items():
        if name in _PLAIN:
            checker.check(section, _PLAIN[name])
    for section in outline.objects.all():
        checker.check(section, _OBJECT)
    for module in outline.modules.values():
        for section in module.fixed.all():
            checker.check(section, _OBJECT)
        for section in module.extensions.values():
            checker.check(section, _EXTENSION)


class _Checker:
    def __init__(self, findings: Findings) -> None:
        self._findings = findings
        self._suggestions = 0

    def check(self, section: Section, keys: _Keys) -> None:
        for key, entry in section.entries.items():
            if key in keys.names or keys.pattern.fullmatch(key):
                continue
            meant = self._similar(key, keys, section)
            if meant is None:
                message = f"{entry.key} is not a key of [{section.name}]"
                self._findings.add(lexical.UNKNOWN_KEY, entry.key_span, message)
            else:
                message = f"{entry.key} is not a key of [{section.name}]; it is ignored"
                self._findings.add(
                    lexical.MISSPELT_KEY,
                    entry.key_span,
                    message,
                    hint=f"did you mean {meant}?",
                )

    def _similar(self, key: str, keys: _Keys, section: Section) -> str | None:
        if self._suggestions >= _MAX_SUGGESTIONS or len(key) > 40:
            return None
        self._suggestions += 1
        near = get_close_matches(key, keys.names, n=1, cutoff=0.85)
        free = near and near[0] not in section.entries
        return keys.names[near[0]] if free else None
