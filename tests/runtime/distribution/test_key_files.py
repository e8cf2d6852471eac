"""Files that configurations of the engines name, which the engines open without a question."""

from __future__ import annotations

import json
import logging
import os
import sys
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest

pytest.importorskip("zenoh")
pytest.importorskip("cyclonedds")

from rtgen.runtime.dds.medium import DdsMedium
from rtgen.runtime.distribution.medium import MediumError
from rtgen.runtime.zenoh.session import Endpoints, open_session

pytestmark = pytest.mark.skipif(sys.platform == "win32", reason="pipes are of POSIX")


def a_pipe(path: Path) -> None:
    os.mkfifo(path)


def zeros(path: Path) -> None:
    path.symlink_to("/dev/zero")


def a_folder(path: Path) -> None:
    path.mkdir()


def much(path: Path) -> None:
    with path.open("wb") as stream:
        stream.truncate(8 << 30)


def nothing(path: Path) -> None:
    """Create no file."""


FILES: dict[Callable[[Path], None], str] = {
    a_pipe: "it is a pipe, not a file",
    zeros: "it is a device, not a file",
    a_folder: "it is a folder, not a file",
    much: "it is larger than 1,048,576 bytes",
    nothing: "No such file or directory",
}

SETTINGS = (
    *(
        f"transport/link/tls/{name}"
        for name in (
            *("root_ca_certificate", "listen_private_key", "listen_certificate"),
            *("connect_private_key", "connect_certificate"),
        )
    ),
    "transport/auth/usrpwd/dictionary_file",
    "transport/auth/pubkey/public_key_file",
    "transport/auth/pubkey/private_key_file",
    "transport/auth/pubkey/known_keys_file",
)


def configured(folder: Path, setting: str, file: Path) -> Endpoints:
    """Return endpoints with a configuration of Zenoh that names a file."""
    value: Any = str(file)
    for key in reversed(setting.split("/")):
        value = {key: value}
    value["mode"] = "peer"
    value["listen"] = {"endpoints": ["tcp/127.0.0.1:0"]}
    value["scouting"] = {"multicast": {"enabled": False}}
    config = folder / "zenoh.json5"
    config.write_text(json.dumps(value))
    return Endpoints(config)


@pytest.mark.parametrize("make", FILES, ids=lambda make: make.__name__)
def test_zenoh_does_not_open_what_is_no_file(
    tmp_path: Path, make: Callable[[Path], None]
) -> None:
    file = tmp_path / "key.pem"
    make(file)
    for setting in SETTINGS:
        with pytest.raises(MediumError) as raised:
            open_session(configured(tmp_path, setting, file))
        assert f"{setting}: {file} cannot be read: {FILES[make]}" in str(raised.value)


@pytest.mark.parametrize("make", FILES, ids=lambda make: make.__name__)
def test_files_of_locators_are_checked(
    tmp_path: Path, make: Callable[[Path], None]
) -> None:
    file = tmp_path / "key.pem"
    make(file)
    locator = f"tls/127.0.0.1:1#so_sndbuf=9;listen_private_key_file={file}"
    for endpoints in (Endpoints(None, (locator,)), Endpoints(None, (), (locator,))):
        with pytest.raises(MediumError, match=f"cannot be read: {FILES[make]}"):
            open_session(endpoints)
    config = tmp_path / "zenoh.json5"
    config.write_text(json.dumps({"listen": {"endpoints": {"peer": [locator]}}}))
    with pytest.raises(MediumError, match=f"cannot be read: {FILES[make]}"):
        open_session(Endpoints(config))


@pytest.mark.parametrize("make", FILES, ids=lambda make: make.__name__)
@pytest.mark.parametrize("element", ["PrivateKey", "IdentityCA", "Governance"])
def test_dds_does_not_open_what_is_no_file(
    tmp_path: Path, make: Callable[[Path], None], element: str
) -> None:
    file = tmp_path / "key & more.pem"
    make(file)
    config = tmp_path / "dds.xml"
    name = str(file).replace("&", "&amp;")
    config.write_text(
        "<CycloneDDS><Domain><Security><Authentication>"
        f"<{element}>\n file:{name} </{element}>"
        "</Authentication></Security></Domain></CycloneDDS>"
    )
    with pytest.raises(MediumError) as raised:
        DdsMedium("x", config=config)
    assert f"{element}: {file} cannot be read: {FILES[make]}" in str(raised.value)


def test_a_private_key_for_everybody_is_reported(
    tmp_path: Path, caplog: pytest.LogCaptureFixture
) -> None:
    key = tmp_path / "key.pem"
    key.write_text("a key")
    for mode, reported in ((0o644, True), (0o640, True), (0o600, False)):
        key.chmod(mode)
        caplog.clear()
        setting = "transport/link/tls/listen_private_key"
        with caplog.at_level(logging.WARNING):
            session = open_session(configured(tmp_path, setting, key))
            session.close()  # type: ignore[no-untyped-call]
        found = [m for m in caplog.messages if "other users may read" in m]
        assert bool(found) is reported
