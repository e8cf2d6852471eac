"""Numbers and values of EDS files (CiA 306, 4.2 and 4.6.3.2)."""

from __future__ import annotations

import math
import re
import struct
from decimal import Decimal
from typing import NamedTuple

from rtgen.compiler.diagnostics import Span
from rtgen.compiler.frontends.eds.findings import Findings
from rtgen.compiler.frontends.eds.ini import Entry
from rtgen.compiler.frontends.eds.rules import lexical, values
from rtgen.compiler.model.canopen import SIGNED, UNSIGNED, DataType, NodeRelative, Value

_NUMBER = re.compile(r"([+-]?)(?:0[xX]([0-9a-fA-F]{1,64})|([0-9]{1,80}))")
_HEX_BEHIND = re.compile(r"([0-9a-fA-F]{1,64})[hH]")
_STANDARD_FORMULA = re.compile(r"\$NODEID(?:\+(?:0x[0-9a-fA-F]+|[0-9]+))?")
_COMMENT = re.compile(r"\s+[;#].*", re.DOTALL)
_HEX_OCTETS = re.compile(r"(?:0[xX])?((?:[0-9a-fA-F]{2})*)")
_REAL = re.compile(r"[+-]?(?:[0-9]+\.?[0-9]*|\.[0-9]+)(?:[eE][+-]?[0-9]+)?([fF]?)")
_DECIMAL = re.compile(r"[+-]?(?:[0-9]+\.?[0-9]*|\.[0-9]+)(?:[eE][+-]?[0-9]{1,3})?")
_MAX_DIGITS = 30
_KNOWN = frozenset(map(int, DataType))
_WORDS = {"true": 1, "false": 0, "yes": 1, "no": 0}
_TEXTS = frozenset({DataType.VISIBLE_STRING, DataType.UNICODE_STRING})
_OCTETS = frozenset({DataType.OCTET_STRING, DataType.DOMAIN})
_TIMES = {DataType.TIME_OF_DAY: 48, DataType.TIME_DIFFERENCE: 48}
_REALS = {DataType.REAL32: ("<I", "<f"), DataType.REAL64: ("<Q", "<d")}


class Number(NamedTuple):
    """A number, with flags for unusual notations."""

    value: int
    octal: bool = False
    odd: bool = False


def parse(text: str) -> Number | None:
    """Parse a number: decimal, hexadecimal with `0x`, or (non-standard) with suffix `h`."""
    match = _NUMBER.fullmatch(text)
    if match is None:
        match = _HEX_BEHIND.fullmatch(text)
        return None if match is None else Number(int(match[1], 16), odd=True)
    digits = match[2] or match[3]
    value = int(digits, 16 if match[2] else 10)
    octal = not match[2] and digits[0] == "0" and value > 7
    return Number(-value if match[1] == "-" else value, octal)


def number(entry: Entry, findings: Findings) -> int | None:
    """Return the number of an entry; None, without a diagnostic, if it is malformed."""
    parsed = parse(without_comment(entry, findings))
    if parsed is None:
        return None
    _report(parsed, entry, findings)
    return parsed.value


def _report(parsed: Number, entry: Entry, findings: Findings) -> None:
    if parsed.octal:
        message = (
            f"{entry.value} is taken for {parsed.value}, though a leading 0 means octal"
        )
        findings.add(values.OCTAL, entry.span, message)
    if parsed.odd:
        message = f"{entry.value} is taken for 0x{parsed.value:X}"
        findings.add(values.ODD_NUMBER, entry.span, message)


def without_comment(entry: Entry, findings: Findings) -> str:
    """Return the value of an entry without a trailing comment."""
    text = _COMMENT.sub("", entry.value)
    if text != entry.value:
        start = entry.value_column + len(text)
        end = entry.value_column + len(entry.value)
        span = Span(entry.file, entry.line, start, entry.line, end)
        message = "a comment must be on its own line"
        findings.add(lexical.STRAY_COMMENT, span, message)
    return text


def value(entry: Entry, type_: int, findings: Findings) -> Value | None:
    """Return the value of an entry for its data type; None, with a diagnostic, if it is invalid."""
    if type_ in _TEXTS:
        return entry.value
    if type_ == DataType.VISIBLE_CHAR and len(entry.value) == 1:
        return entry.value
    text = without_comment(entry, findings)
    if type_ in _OCTETS or type_ not in _KNOWN:
        result: Value | None = _octets(text, entry, findings)
    elif type_ in _REALS:
        result = _real(text, entry, DataType(type_), findings)
    else:
        result = _integer(text, entry, DataType(type_), findings)
    return result


def limit(
    entry: Entry, type_: int, findings: Findings
) -> int | float | NodeRelative | None:
    """Return the limit of an entry for its data type; None, with a diagnostic, if it is invalid."""
    ordered = type_ in SIGNED or type_ in UNSIGNED or type_ in _REALS
    if not ordered and type_ not in (DataType.BOOLEAN, DataType.VISIBLE_CHAR):
        message = f"{entry.key}: values of this data type have no order"
        findings.add(values.NO_LIMIT, entry.key_span, message)
        return None
    number = value(entry, type_, findings)
    return number if isinstance(number, int | float | NodeRelative) else None


def _bad(entry: Entry, findings: Findings, kind: str) -> None:
    message = f"{entry.key}: this is not {kind}; it is ignored"
    findings.add(values.BAD_VALUE, entry.span, message)


def _octets(text: str, entry: Entry, findings: Findings) -> bytes | None:
    match = _HEX_OCTETS.fullmatch(re.sub(r"\s+", "", text))
    if match is None:
        _bad(entry, findings, "hexadecimal octets")
        return None
    if text[:2] in ("0x", "0X"):
        message = "octets have no 0x in front"
        findings.add(values.ODD_NUMBER, entry.span, message)
    return bytes.fromhex(match[1])


def _real(text: str, entry: Entry, type_: DataType, findings: Findings) -> float | None:
    bits, form = _REALS[type_]
    if text[:2] in ("0x", "0X"):
        parsed = parse(text)
        if parsed is not None and parsed.value < 1 << 8 * struct.calcsize(bits):
            message = f"{text} is taken for the bits of a {type_.name}"
            findings.add(values.ODD_NUMBER, entry.span, message)
            [result] = struct.unpack(form, struct.pack(bits, parsed.value))
            return float(result)
    elif (match := _REAL.fullmatch(text)) is not None and len(text) <= 80:
        if match[1]:
            message = f"{text} is taken for {text[:-1]}"
            findings.add(values.ODD_NUMBER, entry.span, message)
        result = float(text.rstrip("fF"))
        try:
            struct.pack(form, result)
        except OverflowError:
            result = math.inf
        if math.isinf(result):
            _out_of_range(entry, type_, findings)
            return None
        return result
    _bad(entry, findings, "a number")
    return None


def _integer(
    text: str, entry: Entry, type_: DataType, findings: Findings
) -> int | NodeRelative | None:
    if "$" in text:
        formula = _formula(text, entry, findings)
        if formula is None:
            _bad(entry, findings, "a number or formula with $NODEID")
        elif abs(formula.offset) >= 1 << 64:
            _out_of_range(entry, type_, findings)
            formula = None
        return formula
    if type_ is DataType.BOOLEAN and text.lower() in _WORDS:
        result = _WORDS[text.lower()]
        message = f"{text} is taken for {result}"
        findings.add(values.ODD_NUMBER, entry.span, message)
        return result
    parsed = parse(text)
    number = _whole(text) if parsed is None else parsed.value
    if number is None:
        _bad(entry, findings, "a number")
        return None
    fitted = _fitted(number, type_)
    if fitted is None:
        _out_of_range(entry, type_, findings)
    elif parsed is None:
        message = f"{entry.key}: {text} is taken for {number}"
        findings.add(values.ODD_NUMBER, entry.span, message)
    if parsed is not None:
        _report(parsed, entry, findings)
    return fitted


def _whole(text: str) -> int | None:
    """Return the integer that a number with a fraction or an exponent is; None for others."""
    if len(text) > _MAX_DIGITS or _DECIMAL.fullmatch(text) is None:
        return None
    number = Decimal(text)
    if number.adjusted() > _MAX_DIGITS or number != number.to_integral_value():
        return None
    return int(number)


def _out_of_range(entry: Entry, type_: DataType, findings: Findings) -> None:
    message = f"{entry.key}: no {type_.name} is {entry.value[:40]}; it is ignored"
    findings.add(values.OUT_OF_RANGE, entry.span, message)


def _fitted(number: int, type_: DataType) -> int | None:
    """Return the number in the type's range; two's complement of a signed type becomes negative."""
    if type_ in SIGNED:
        width = SIGNED[type_]
        if 1 << width - 1 <= number < 1 << width:
            number -= 1 << width
        return number if -(1 << width - 1) <= number < 1 << width - 1 else None
    width = {**UNSIGNED, **_TIMES, DataType.VISIBLE_CHAR: 8}.get(type_, 1)
    if -(1 << width - 1) <= number < 0 and type_ in UNSIGNED:
        return number + (1 << width)
    return number if 0 <= number < 1 << width else None


def _formula(text: str, entry: Entry, findings: Findings) -> NodeRelative | None:
    """Parse `$NODEID+number`, with terms in any order and case, and more of them."""
    offset, nodes = 0, 0
    for sign, term in re.findall(r"([+-]?)([^+-]*)", re.sub(r"\s+", "", text)):
        if term.upper() == "$NODEID" and sign != "-":
            nodes += 1
        elif term:
            parsed = parse(term)
            if parsed is None:
                return None
            offset += -parsed.value if sign == "-" else parsed.value
        elif sign:
            return None
    if nodes != 1:
        return None
    if _STANDARD_FORMULA.fullmatch(text) is None:
        message = f"{text} is taken for {NodeRelative(offset)}"
        findings.add(values.FORMULA, entry.span, message)
    return NodeRelative(offset)
