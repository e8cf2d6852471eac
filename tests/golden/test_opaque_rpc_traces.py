"""Calls recorded between peers that tecsgen made, replayed with generated codecs."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import pytest

from rtgen.cli import run

TRACES = Path(__file__).parent / "tecs" / "opaque_rpc_traces.json"


def test_all_recorded_calls_are_equal(capsys: pytest.CaptureFixture[str]) -> None:
    assert run(["rpc", "replay", str(TRACES)]) == 0
    assert capsys.readouterr().out == "150 cases, 150 equal\n"


def altered(number: int, **changes: Any) -> dict[str, Any]:
    traces: dict[str, Any] = json.loads(TRACES.read_text("utf-8"))
    case = traces["cases"][number]
    traces["cases"] = [{**case, **changes}]
    traces["shared_channel_cases"] = []
    return traces


@pytest.mark.parametrize(
    ("number", "changes", "message"),
    [
        (2, {"response": "561e00000000556d5e"}, "outs: "),
        (2, {"outs": {"outdata": 85}}, "reply: "),
        (2, {"request": "672a00035a3c"}, "this is another function"),
        (2, {"return": 1}, "return value: "),
        (3, {"args": {"indata": 1, "iodata": 4096}}, "arguments: "),
        (0, {"response": "561e000000006d"}, "1 bytes are missing (E_BOVR)"),
        (0, {"response": "561e000000006d5e00"}, "1 bytes are left over"),
        (0, {"args": {}}, "'indata' is missing"),
        (0, {"function": "none"}, "no function 'none'"),
    ],
)
def test_each_difference_is_reported(
    tmp_path: Path,
    capsys: pytest.CaptureFixture[str],
    number: int,
    changes: dict[str, Any],
    message: str,
) -> None:
    path = tmp_path / "traces.json"
    path.write_text(json.dumps(altered(number, **changes)), "utf-8")
    assert run(["rpc", "replay", str(path)]) == 1
    text = capsys.readouterr().out
    assert text.startswith("1 cases, 0 equal\n")
    assert message in text


def test_verbose_names_the_equal_cases(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    path = tmp_path / "traces.json"
    path.write_text(json.dumps(altered(0)), "utf-8")
    assert run(["rpc", "replay", "--verbose", str(path)]) == 0
    assert "\ntNBOTDR/sServer/func1/0: equal\n" in capsys.readouterr().out


def test_a_file_of_something_else_is_refused(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    path = tmp_path / "traces.json"
    for text in ("{", "[]", '{"format": "other"}'):
        path.write_text(text, "utf-8")
        assert run(["rpc", "replay", str(path)]) == 2
    assert "no file of the format opaque-rpc-trace/1" in capsys.readouterr().err
