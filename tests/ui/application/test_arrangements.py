"""Arrangements of the wiring over real sockets: pages with full rights store them for all pages."""

from __future__ import annotations

import json
import os
import stat
from collections.abc import Iterator
from http.client import HTTPConnection
from pathlib import Path
from typing import Any

import pytest
from hostile_session import Hostile
from patience import PATIENCE
from ui_bench import serving

from rtgen.compiler.kit import stored_files
from rtgen.ui.arrangements import MAX_OCTETS, Arrangements, of_user
from rtgen.ui.serving import Server

KEY = "0123456789abcdef" * 4
FORM: dict[str, Any] = {
    "width": 100,
    "height": 50.5,
    "boxes": [["a", 0, 0.25], ["</script>", 1e3, -2]],
    "wires": [["a to b", [[0, 1], [2.5, 3]]], ["", []]],
}
DATA = json.dumps(FORM).encode()


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    return tmp_path_factory.mktemp("cache") / "arrangements"


@pytest.fixture(scope="module")
def server(folder: Path) -> Iterator[Server]:
    stored = Arrangements(folder)
    with serving(Server(Hostile(), "127.0.0.1", 0, arrangements=stored)) as server:
        yield server


@pytest.fixture
def empty(folder: Path) -> Path:
    """Return the folder, without arrangements."""
    for file in [*folder.iterdir()] if folder.is_dir() else ():
        file.unlink()
    return folder


def ask(
    server: Server,
    data: bytes | None = None,
    *,
    key: str = KEY,
    token: str | None = None,
    **headers: str,
) -> tuple[int, bytes, str]:
    """Ask for an arrangement, or store one; return status, body and what is allowed."""
    connection = HTTPConnection(server.host, server.port, timeout=PATIENCE)
    shown = server.tokens.full if token is None else token
    method = "GET" if data is None else "PUT"
    try:
        connection.request(
            method, f"/arrangements/{key}?token={shown}", data, headers=headers
        )
        answer = connection.getresponse()
        return answer.status, answer.read(), answer.headers.get("allow", "")
    finally:
        connection.close()


def test_what_a_page_has_stored_is_there_for_all(server: Server, empty: Path) -> None:
    read_only = server.tokens.read_only
    assert ask(server) == (204, b"", "GET, PUT")
    assert ask(server, token=read_only) == (204, b"", "GET")
    assert ask(server, DATA)[0] == 204
    assert ask(server) == (200, DATA, "GET, PUT")
    assert ask(server, token=read_only) == (200, DATA, "GET")
    assert ask(server, key=KEY[::-1])[0] == 204
    [file] = empty.iterdir()
    assert stat.S_IMODE(file.stat().st_mode) == 0o600
    other = DATA.replace(b"100", b"200")
    assert ask(server, other)[0] == 204
    assert ask(server) == (200, other, "GET, PUT")
    assert [*empty.iterdir()] == [file]


def test_only_pages_of_the_server_with_full_rights_store(
    server: Server, empty: Path
) -> None:
    assert ask(server, DATA, token=server.tokens.read_only)[0] == 405
    assert ask(server, DATA, token="wrong")[0] == 404
    assert ask(server, DATA, Origin="http://example.org")[0] == 403
    assert ask(server, DATA, Host=f"example.org:{server.port}")[0] == 403
    for key in ("", KEY[1:], f"{KEY}0", KEY.upper(), f"../{KEY[3:]}", f"{KEY}%0a"):
        assert ask(server, DATA, key=key)[0] == 404, key
    assert not empty.exists() or not [*empty.iterdir()]


@pytest.mark.parametrize(
    "data",
    [
        b"",
        b"\xff",
        b"[]",
        b"[" * 100_000,
        DATA[:-1],
        json.dumps({**FORM, "more": 1}).encode(),
        json.dumps({**FORM, "width": None}).encode(),
        DATA.replace(b"50.5", b"NaN"),
        DATA.replace(b"50.5", b"1e999"),
        DATA.replace(b"50.5", b"9" * 400),
        DATA.replace(b'"a"', b"1"),
        DATA.replace(b"[2.5, 3]", b"[2.5]"),
        DATA + b" " * MAX_OCTETS,
    ],
    ids=lambda data: repr(data[:60]),
)
def test_what_is_no_arrangement_is_neither_stored_nor_given(
    server: Server, empty: Path, data: bytes
) -> None:
    ask(server, DATA)
    assert ask(server, data)[0] == 400
    assert ask(server)[:2] == (200, DATA)
    [file] = empty.iterdir()
    file.write_bytes(data)
    assert ask(server)[0] == 204


@pytest.mark.skipif(not hasattr(os, "getuid"), reason="files have no modes here")
def test_a_file_that_others_can_write_is_not_given(server: Server, empty: Path) -> None:
    ask(server, DATA)
    [file] = empty.iterdir()
    file.chmod(0o622)
    assert ask(server)[0] == 204


def test_those_that_are_used_stay(
    server: Server, empty: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(stored_files, "_MAX_FILES", 2)
    keys = [digit * 64 for digit in "abc"]
    for second, key in enumerate(keys[:2]):
        ask(server, DATA, key=key)
        os.utime(empty / f"{key}.json", (second, second))
    ask(server, key=keys[0])
    ask(server, DATA, key=keys[2])
    assert [ask(server, key=key)[0] for key in keys] == [200, 204, 200]


def test_without_a_folder_nothing_is_stored(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setenv("RTGEN_CACHE_DIR", str(tmp_path / "cache"))
    (tmp_path / "cache").touch()
    with serving(Server(Hostile(), "127.0.0.1", 0, arrangements=of_user())) as server:
        assert ask(server, DATA)[0] == 204
        assert ask(server)[0] == 204
    (tmp_path / "cache").unlink()
    with serving(Server(Hostile(), "127.0.0.1", 0)) as server:
        assert ask(server, DATA)[0] == 405
        assert ask(server) == (204, b"", "GET")
    assert not [*tmp_path.iterdir()]
    of_user().put(KEY, DATA)
    assert of_user().get(KEY) == DATA
    assert [*tmp_path.glob("**/*.json")]
