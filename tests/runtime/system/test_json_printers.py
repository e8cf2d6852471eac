"""Printers of values as JSON give what `json.dumps` makes of the plain value."""

from __future__ import annotations

import json
from math import inf, nan
from typing import Any

import pytest
from hypothesis import given
from hypothesis import strategies as st

from refrobots import iis, rtc, ucode
from rtgen.runtime.system.json_printers import json_printer, plain

FLOATS = st.floats()
TIMES = st.builds(rtc.Time, st.integers(0, 2**32 - 1), st.integers(0, 10**9))
NUMBERS = st.lists(FLOATS, max_size=3)
IDS = st.lists(st.integers(-(2**31), 2**31 - 1), max_size=3)
SAMPLES = st.one_of(
    st.builds(
        iis.TimedVelocity2D,
        TIMES,
        IDS,
        st.builds(rtc.Velocity2D, FLOATS, FLOATS, FLOATS),
        NUMBERS,
    ),
    st.builds(rtc.TimedDoubleSeq, TIMES, NUMBERS),
    st.builds(rtc.TimedOctetSeq, TIMES, st.binary(max_size=5)),
    st.builds(rtc.TimedString, TIMES, st.text(max_size=5)),
    st.builds(rtc.TimedBoolean, TIMES, st.booleans()),
    st.builds(
        ucode.TimedRecord, TIMES, st.binary(min_size=16, max_size=16), st.booleans()
    ),
    st.builds(rtc.RangeData, TIMES, NUMBERS),
)


@given(SAMPLES)
def test_a_value_is_printed_as_its_plain_form(sample: Any) -> None:
    assert json_printer(type(sample))(sample) == json.dumps(
        plain(sample), ensure_ascii=False
    )


@pytest.mark.parametrize(
    ("sample", "printed"),
    [
        # Values that no definition allows, but a behaviour may write.
        (rtc.TimedState(data=iis.State.TURNING), '"data": "TURNING"'),
        (rtc.TimedDouble(data=3), '"data": 3'),
        (rtc.TimedDouble(data=True), '"data": true'),
        (rtc.TimedDouble(data=nan), '"data": "nan"'),
        (rtc.TimedDouble(data=-inf), '"data": "-inf"'),
        (rtc.TimedDoubleSeq(data=[1.0, inf]), '"data": [1.0, "inf"]'),
        (rtc.TimedDoubleSeq(data=[True]), '"data": [true]'),
        (rtc.TimedDoubleSeq(data=(0.5,)), '"data": [0.5]'),
        (rtc.TimedDouble(data=1e308), '"data": 1e+308'),
        (rtc.TimedString(data='{"%s"}'), '"data": "{\\"%s\\"}"'),
    ],
)
def test_values_that_are_not_what_they_are_declared(sample: Any, printed: str) -> None:
    text = json_printer(type(sample))(sample)
    assert printed in text
    assert text == json.dumps(plain(sample), ensure_ascii=False)
