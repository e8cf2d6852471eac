"""Texts of the values in profiles and configurations of other processes."""

from __future__ import annotations

from typing import Any

import pytest

pytest.importorskip("omniORB", reason="omniORBpy is not installed")

from omniORB import CORBA, tcInternal
from omniORB import any as anys

from rtgen.runtime.corba.rt_objects.wire import text_of

DEPTH = 3000
"""More values within each other than Python has calls; 12 kB on the wire."""


def alias(type_: Any) -> Any:
    return tcInternal.createTypeCode((tcInternal.tv_alias, "IDL:A:1.0", "A", type_))


def nested(value: Any) -> Any:
    for _ in range(DEPTH):
        value = CORBA.Any(CORBA.TC_any, value)
    return value


@pytest.mark.parametrize(
    ("value", "text"),
    [
        (anys.to_any("some"), "some"),
        (anys.to_any(5), "5"),
        (anys.to_any(0.5), "0.5"),
        (CORBA.Any(CORBA.TC_boolean, 1), "true"),
        (CORBA.Any(alias(tcInternal.tv_boolean), 0), "false"),
        (CORBA.Any(alias(tcInternal.tv_any), anys.to_any("some")), "some"),
        (anys.to_any(["some", 5]), None),
        (CORBA.Any(CORBA.TC_null, None), None),
        (CORBA.Any(CORBA.TC_Object, None), None),
        (CORBA.Any(CORBA.TC_TypeCode, CORBA.TC_long), None),
        (nested(anys.to_any("some")), "some"),
        (nested(CORBA.Any(CORBA.TC_null, None)), None),
    ],
    ids=range(12),
)
def test_values_of_simple_types_have_texts(value: Any, text: str | None) -> None:
    assert text_of(value) == text
