"""Reads a variable from its section (CiA 306, 4.6.3.2)."""

from __future__ import annotations

from enum import IntEnum

from rtgen.compiler.diagnostics import Span
from rtgen.compiler.frontends.eds import numbers
from rtgen.compiler.frontends.eds.findings import Findings
from rtgen.compiler.frontends.eds.ini import Entry, Section
from rtgen.compiler.frontends.eds.rules import information, values
from rtgen.compiler.frontends.eds.rules import objects as rules
from rtgen.compiler.model.canopen import Access, DataType, NodeRelative, Value, Variable
from rtgen.compiler.typemap.canopen.communication import type_of

KNOWN = frozenset(map(int, DataType))
"""The codes of the basic data types."""

_OTHER_ACCESS = {
    "r": Access.RO,
    "read": Access.RO,
    "readonly": Access.RO,
    "w": Access.WO,
    "write": Access.WO,
    "writeonly": Access.WO,
    "wr": Access.RW,
    "r/w": Access.RW,
    "readwrite": Access.RW,
    "constant": Access.CONST,
}
_LAST_TYPE = 0xFFFF
_DCF_KEYS = ("ParameterValue", "Denotation", "UploadFile", "DownloadFile")


def _value_place(section: Section, default: Value | None, value: Value | None) -> Span:
    for key, declared in (("ParameterValue", value), ("DefaultValue", default)):
        entry = section.get(key)
        if entry is not None and declared is not None:
            return entry.span
    return section.span


class VariableReader:
    """Reads variables; `types` are the subranges defined by the file, by code."""

    def __init__(self, findings: Findings, types: dict[int, int], dcf: bool) -> None:
        self._findings = findings
        self._types = types
        self._warned_of_dcf = dcf

    def name(self, section: Section, fallback: str) -> str:
        """Return the name of an object or sub-object."""
        name = section.text("ParameterName")
        if not name:
            message = f"ParameterName is missing; it is called {fallback}"
            self._findings.add(rules.NO_NAME, section.span, message)
        return name or fallback

    def read(
        self,
        section: Section,
        index: int,
        subindex: int,
        name: str,
        *,
        domain: bool = False,
        common: int | None = None,
    ) -> Variable | None:
        """Read a variable; None, with an error, if it has no data type.

        `common` is the data type of the surrounding ARRAY.
        """
        entry = section.get("ObjectType")
        if entry is not None and subindex:
            domain = self.word(entry, {"VAR": 7, "DOMAIN": 2}) == 2
        data_type = self._data_type(section, index, subindex, domain, common)
        if data_type is None:
            return None
        access, written = self._access(section)
        self.warn_of_dcf(section)
        default = self._value(section, "DefaultValue", data_type)
        value = self._value(section, "ParameterValue", data_type)
        low, high = self._limits(section, data_type)
        for key, declared in (("DefaultValue", default), ("ParameterValue", value)):
            self._check_limits(section, key, declared, low, high)
        return Variable(
            index=index,
            subindex=subindex,
            name=name,
            data_type=data_type,
            access=access,
            written_access=written,
            span=section.span,
            value_span=_value_place(section, default, value),
            domain=domain,
            pdo_mappable=self._flag(section, "PDOMapping"),
            default=default,
            value=value,
            low=low,
            high=high,
            unit=section.text("Unit"),
            factor=self._factor(section),
            description=section.text("Description"),
            denotation=section.text("Denotation"),
            flags=self.flags(section),
            upload_file=section.text("UploadFile"),
            download_file=section.text("DownloadFile"),
        )

    def word(self, entry: Entry, names: type[IntEnum] | dict[str, int]) -> int | None:
        """Return a number, or the number of an enumerator's name; None for anything else."""
        word = entry.value.upper()
        members = names if isinstance(names, dict) else dict(names.__members__)
        if word in members:
            result = int(members[word])
            message = (
                f"{entry.key} is a number; {entry.value} is taken for 0x{result:X}"
            )
            self._findings.add(rules.WORDS, entry.span, message)
            return result
        return numbers.number(entry, self._findings)

    def _data_type(
        self,
        section: Section,
        index: int,
        subindex: int,
        domain: bool,
        common: int | None,
    ) -> int | None:
        entry = section.get("DataType")
        code = None if entry is None else self.word(entry, DataType)
        span = section.span if entry is None else entry.span
        if code is None or not 0 <= code <= _LAST_TYPE:
            code = self._likely_type(section, index, subindex, domain, common)
            state = "missing" if entry is None else "no number"
            if code is None:
                message = f"DataType is {state}"
                self._findings.add(rules.NO_TYPE, span, message)
                return None
            name = DataType(code).name if code in KNOWN else f"0x{code:04X}"
            message = f"DataType is {state}; it is taken for {name}"
            self._findings.add(rules.TYPE_TAKEN, span, message)
        code = self._types.get(code, code)
        if code not in KNOWN:
            message = f"unknown data type 0x{code:04X}; values of it are raw octets"
            self._findings.add(rules.UNKNOWN_TYPE, span, message)
            return code
        return DataType(code)

    @staticmethod
    def _likely_type(
        section: Section, index: int, subindex: int, domain: bool, common: int | None
    ) -> int | None:
        if subindex == 0 and "sub" in section.name.lower():
            return DataType.UNSIGNED8
        if domain:
            return DataType.DOMAIN
        return common if common is not None else type_of(index, subindex)

    def _access(self, section: Section) -> tuple[Access, str]:
        entry = section.get("AccessType")
        if entry is None:
            message = "AccessType is missing; it is taken for ro"
            self._findings.add(rules.NO_ACCESS, section.span, message)
            return Access.RO, Access.RO.value
        word = numbers.without_comment(entry, self._findings)
        written = word.lower()
        if written in Access.__members__.values():
            return Access(written), written
        meant = _OTHER_ACCESS.get(written, Access.RO)
        message = f"{word[:40]} is not an access type; it is taken for {meant}"
        self._findings.add(rules.UNKNOWN_ACCESS, entry.span, message)
        return meant, written

    def _value(self, section: Section, key: str, data_type: int) -> Value | None:
        entry = section.get(key)
        return (
            None if entry is None else numbers.value(entry, data_type, self._findings)
        )

    def _limits(
        self, section: Section, data_type: int
    ) -> tuple[int | float | NodeRelative | None, int | float | NodeRelative | None]:
        low, high = (
            (
                None
                if (entry := section.get(key)) is None
                else numbers.limit(entry, data_type, self._findings)
            )
            for key in ("LowLimit", "HighLimit")
        )
        if (
            isinstance(low, int | float)
            and isinstance(high, int | float)
            and low > high
        ):
            entry = section.get("LowLimit")
            assert entry is not None
            message = f"LowLimit {low} is above HighLimit {high}; both are ignored"
            self._findings.add(values.LIMITS_CROSSED, entry.span, message)
            return None, None
        return low, high

    def _check_limits(
        self,
        section: Section,
        key: str,
        declared: Value | None,
        low: int | float | NodeRelative | None,
        high: int | float | NodeRelative | None,
    ) -> None:
        if not isinstance(declared, int | float):
            return
        below = isinstance(low, int | float) and declared < low
        if below or (isinstance(high, int | float) and declared > high):
            entry = section.get(key)
            assert entry is not None
            limit = f"below LowLimit {low}" if below else f"above HighLimit {high}"
            message = f"{key} {declared} is {limit}"
            self._findings.add(values.OUTSIDE_LIMITS, entry.span, message)

    def _factor(self, section: Section) -> float | None:
        entry = section.get("Factor")
        if entry is None:
            return None
        factor = numbers.value(entry, DataType.REAL64, self._findings)
        return factor if isinstance(factor, float) else None

    def flags(self, section: Section) -> int:
        """Return the object flags, 0 by default."""
        entry = section.get("ObjFlags")
        declared = None if entry is None else numbers.number(entry, self._findings)
        if entry is not None and (declared is None or not 0 <= declared <= 0xFFFFFFFF):
            message = f"ObjFlags is {entry.value[:40]!r}, not a number of 32 bits"
            self._findings.add(information.BAD_INFORMATION, entry.span, message)
            return 0
        return declared or 0

    def _flag(self, section: Section, key: str) -> bool:
        entry = section.get(key)
        if entry is None:
            return False
        declared = numbers.number(entry, self._findings)
        if declared is None or declared in (0, 1):
            return numbers.value(entry, DataType.BOOLEAN, self._findings) == 1
        message = f"{entry.key} is {declared}, not 0 or 1; it is taken for 1"
        self._findings.add(information.BAD_INFORMATION, entry.span, message)
        return True

    def warn_of_dcf(self, section: Section, *, whole: bool = False) -> None:
        """Warn once per file that the section has, or is, what only a DCF can contain."""
        if self._warned_of_dcf:
            return
        for name in _DCF_KEYS:
            entry = section.get(name)
            if entry is not None:
                self._warned_of_dcf = True
                message = f"{entry.key} belongs to a DCF"
                self._findings.add(information.OF_A_DCF, entry.key_span, message)
                return
        if whole:
            self._warned_of_dcf = True
            message = f"[{section.name}] belongs to a DCF"
            self._findings.add(information.OF_A_DCF, section.span, message)
