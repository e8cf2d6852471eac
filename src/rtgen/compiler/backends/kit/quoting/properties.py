"""Configuration files of OpenRTM (`key: value`) and EDS files.

OpenRTM reads a line up to its end, takes the text before the first `:` or `=` as the key, removes
backslashes (a letter after one may stand for a control character), strips both, and interprets a
backslash at the end of a line and a leading `#` or `!`.
"""

from __future__ import annotations

import re

from rtgen.compiler.backends.kit.quoting.code import Code, HashComment, UnquotableError
from rtgen.compiler.backends.kit.quoting.python import comment_text

_VALUE = re.compile(r"(?:\S(?:.*\S)?)?(?<!\\)", re.DOTALL)
_KEY = re.compile(r"(?:[^\s\\:=#!](?:[^\\:=]*[^\s\\:=])?)?")
_OTHER_LINE_ENDS_AND_CONTROL = re.compile(
    r"[\x00-\x1f\x7f-\x9f\u2028\u2029\ud800-\udfff\ufeff]"
)


class Conf(Code):
    """Lines or parts of lines of a configuration file."""

    __slots__ = ()


def is_conf_value(text: str) -> bool:
    """Return whether the text can be a value in a configuration file."""
    return _is_one_line(text) and _VALUE.fullmatch(text) is not None


def is_conf_key(text: str) -> bool:
    """Return whether the text, possibly empty, can be a part of a key in a configuration file."""
    return _is_one_line(text) and _KEY.fullmatch(text) is not None


def _is_one_line(text: str) -> bool:
    return _OTHER_LINE_ENDS_AND_CONTROL.search(text) is None


def conf_value(value: object) -> Conf:
    """Quote a value. Raises UnquotableError for texts that a line cannot represent."""
    text = str(value)
    if not is_conf_value(text):
        raise UnquotableError(text, "a configuration file")
    return Conf(text.replace("\\", "\\\\"))


def conf_key(value: object) -> Conf:
    """Quote a part of a key. Raises UnquotableError."""
    text = str(value)
    if not is_conf_key(text):
        raise UnquotableError(text, "the key of a configuration file")
    return Conf(text)


def conf_comment(text: str) -> Conf:
    """Return a comment line; a trailing backslash cannot join the next line."""
    return Conf(comment_text(text))


def eds_line(text: str) -> str:
    """Return a line of an EDS or DCF file. Raises UnquotableError for several lines."""
    if "\n" in text or "\r" in text:
        raise UnquotableError(text, "an EDS file")
    return text


def quote_conf(value: object) -> str:
    """Filter of templates of configuration files: accepts code, quotes values."""
    return value if isinstance(value, Conf | HashComment) else conf_value(value)
