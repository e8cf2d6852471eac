"""Namespaces of RtcProfile files, and values of attributes."""

from __future__ import annotations

RTC = "http://www.openrtp.org/namespaces/rtc"
RTC_DOC = "http://www.openrtp.org/namespaces/rtc_doc"
RTC_EXT = "http://www.openrtp.org/namespaces/rtc_ext"

COMPONENT_TYPES = ("STATIC", "UNIQUE", "COMMUTATIVE")
WIDGET = "__widget__"
"""The property of a parameter with the name of its widget."""
