"""Sections about the file and the device (CiA 306, 4.5), and those of a DCF (5.2)."""

from __future__ import annotations

import re

from rtgen.compiler.frontends.eds.findings import Findings
from rtgen.compiler.frontends.eds.ini import Document, Entry, Section
from rtgen.compiler.frontends.eds.lists import check_count
from rtgen.compiler.frontends.eds.numbers import number, parse
from rtgen.compiler.frontends.eds.outline import COMMISSIONING, LISTS, PLAIN, Outline
from rtgen.compiler.frontends.eds.rules import information
from rtgen.compiler.model.canopen import (
    BIT_RATES,
    BITS,
    Commissioning,
    DeviceInfo,
    FileInfo,
)

_U8, _U16, _U32 = 0xFF, 0xFFFF, 0xFFFFFFFF
_DATE = re.compile(r"(?:0?[1-9]|1[0-2])-(?:0?[1-9]|[12][0-9]|3[01])-[0-9]{4}")
_TIME = re.compile(r"(?:0?[0-9]|1[0-2]):[0-5][0-9]\s?[AP]M", re.IGNORECASE)
_VERSION = re.compile(r"[0-9]+\.[0-9]+")
_RATE = re.compile(r"baudrate_([0-9]{1,5})")
_DUMMY = re.compile(r"dummy([0-9a-f]{4})")


class Information:
    """Reads the sections about the file and the device."""

    def __init__(
        self, document: Document, outline: Outline, findings: Findings, dcf: bool
    ) -> None:
        self._document = document
        self._sections = outline.plain
        self._findings = findings
        self._dcf = dcf

    def check_sections(self) -> None:
        """Report missing sections."""
        required = ["fileinfo", "deviceinfo", *LISTS]
        if self._dcf:
            required.append(COMMISSIONING)
        missing = [
            f"[{PLAIN[name]}]" for name in required if name not in self._sections
        ]
        if missing:
            message = f"missing: {', '.join(missing)}"
            self._findings.add(
                information.MISSING_SECTION, self._document.start, message
            )
        if not self._dcf and COMMISSIONING in self._sections:
            section = self._sections[COMMISSIONING]
            message = f"[{section.name}] belongs to a DCF"
            self._findings.add(information.OF_A_DCF, section.span, message)

    def file_info(self) -> FileInfo:
        """Read the section FileInfo."""
        section = self._section("fileinfo")
        self._require(section, "FileName FileVersion FileRevision EDSVersion")
        version = section.get("EDSVersion")
        return FileInfo(
            file_name=section.text("FileName"),
            version=self._number(section, "FileVersion", _U8),
            revision=self._number(section, "FileRevision", _U8),
            eds_version=self._formed(version, _VERSION, "a version x.y") or "3.0",
            description=section.text("Description"),
            created=self._when(section, "Creation"),
            created_by=section.text("CreatedBy"),
            modified=self._when(section, "Modification"),
            modified_by=section.text("ModifiedBy"),
            last_eds=section.text("LastEDS"),
        )

    def _when(self, section: Section, what: str) -> tuple[str, str]:
        date = section.get(f"{what}Date")
        time = section.get(f"{what}Time")
        return (
            self._formed(date, _DATE, "a date mm-dd-yyyy"),
            self._formed(time, _TIME, "a time hh:mmAM"),
        )

    def device_info(self) -> DeviceInfo:
        """Read the section DeviceInfo."""
        section = self._section("deviceinfo")
        self._require(
            section,
            "VendorName VendorNumber ProductName ProductNumber NrOfRXPDO NrOfTXPDO",
        )
        return DeviceInfo(
            vendor_name=section.text("VendorName"),
            vendor_number=self._number(section, "VendorNumber", _U32),
            product_name=section.text("ProductName"),
            product_number=self._number(section, "ProductNumber", _U32),
            revision_number=self._number(section, "RevisionNumber", _U32),
            order_code=section.text("OrderCode"),
            bit_rates=self._bit_rates(section),
            boot_up_master=self._flag(section, "SimpleBootUpMaster"),
            boot_up_slave=self._flag(section, "SimpleBootUpSlave"),
            granularity=self._number(section, "Granularity", 64),
            dynamic_channels=self._number(section, "DynamicChannelsSupported", _U8)
            or 0,
            compact_pdo=self._number(section, "CompactPDO", 0x3F) or 0,
            group_messaging=self._flag(section, "GroupMessaging"),
            rpdos=self._number(section, "NrOfRXPDO", 512),
            tpdos=self._number(section, "NrOfTXPDO", 512),
            lss=self._flag(section, "LSS_Supported"),
        )

    def _bit_rates(self, section: Section) -> tuple[int, ...]:
        rates = []
        for key, entry in section.entries.items():
            match = _RATE.fullmatch(key)
            if match is not None and entry.value and self._flag(section, entry.key):
                rates.append(int(match[1]))
        return tuple(sorted(set(rates)))

    def commissioning(self) -> Commissioning | None:
        """Read the section DeviceComissioning; None without one."""
        section = self._sections.get(COMMISSIONING)
        if section is None:
            return None
        return Commissioning(
            node_id=self._node_id(section),
            node_name=section.text("NodeName"),
            bit_rate=self._bit_rate(section),
            net_number=self._number(section, "NetNumber", _U32),
            network_name=section.text("NetworkName"),
            manager=self._flag(section, "CANopenManager"),
            serial_number=self._number(section, "LSS_SerialNumber", _U32),
        )

    def _node_id(self, section: Section) -> int | None:
        entry = section.get("NodeID")
        if entry is None:
            return None
        declared = number(entry, self._findings)
        if declared is not None and 1 <= declared <= 127:
            return declared
        message = f"{entry.value[:40]} is not a node-id (1 to 127)"
        self._findings.add(information.NODE_ID, entry.span, message)
        return None

    def _bit_rate(self, section: Section) -> int | None:
        declared = self._number(section, "Baudrate", _U32)
        if declared is None or declared in BIT_RATES:
            return declared
        entry = section.get("Baudrate")
        assert entry is not None
        in_bits = declared % 1000 == 0 and declared // 1000 in BIT_RATES
        meaning = f"; it is taken for {declared // 1000} kbit/s" if in_bits else ""
        message = f"{declared} is none of CiA 301's bit rates in kbit/s{meaning}"
        self._findings.add(information.BIT_RATE, entry.span, message)
        return declared // 1000 if in_bits else declared

    def dummies(self) -> tuple[int, ...]:
        """Return the data types that DummyUsage allows as gaps."""
        section = self._section("dummyusage")
        allowed = []
        for key, entry in section.entries.items():
            match = _DUMMY.fullmatch(key)
            if match is None or not entry.value:
                continue
            code = int(match[1], 16)
            if code not in BITS:
                message = f"{entry.key}: no data type of fixed width"
                self._findings.add(information.BAD_DUMMY, entry.key_span, message)
            elif self._flag(section, entry.key):
                allowed.append(code)
        return tuple(sorted(allowed))

    def comments(self) -> str:
        """Return the lines of the section Comments."""
        section = self._section("comments")
        lines = {
            int(key[4:]): entry.value
            for key, entry in section.entries.items()
            if re.fullmatch("line[0-9]{1,5}", key)
        }
        if section.name:
            check_count(section, "Lines", len(lines), self._findings)
        return "\n".join(lines[number] for number in sorted(lines))

    def _section(self, name: str) -> Section:
        """Return the section of that name; an empty one if it is missing."""
        nothing = Section("", self._document.start)
        return self._sections.get(name, nothing)

    def _require(self, section: Section, keys: str) -> None:
        missing = [key for key in keys.split() if key.lower() not in section.entries]
        if missing and section.name:
            message = f"[{section.name}] has no {', '.join(missing)}"
            self._findings.add(information.MISSING_KEYS, section.span, message)

    def _number(self, section: Section, key: str, most: int) -> int | None:
        entry = section.get(key)
        if entry is None:
            return None
        declared = number(entry, self._findings)
        if declared is None or not 0 <= declared <= most:
            self._bad(entry, f"a number of 0 to {most}")
            return None
        return declared

    def _flag(self, section: Section, key: str) -> bool:
        entry = section.get(key)
        if entry is None:
            return False
        declared = parse(entry.value.split()[0])
        if declared is None or declared.value not in (0, 1):
            self._bad(entry, "0 or 1")
        return declared is not None and declared.value != 0

    def _formed(self, entry: Entry | None, form: re.Pattern[str], what: str) -> str:
        if entry is None:
            return ""
        if form.fullmatch(entry.value) is None:
            self._bad(entry, what)
        return entry.value

    def _bad(self, entry: Entry, expectation: str) -> None:
        message = f"{entry.key} is {entry.value[:40]!r}, not {expectation}"
        self._findings.add(information.BAD_INFORMATION, entry.span, message)
