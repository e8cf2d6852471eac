"""The link of a communication RTC: its settings, and the effect of changes."""

from __future__ import annotations

import threading
from dataclasses import dataclass, field
from typing import Any

import pytest

from rtgen.runtime.opaque_rpc import (
    E_NOEXS,
    E_TMOUT,
    ChannelError,
    Link,
    LinkSettings,
    SerialChannel,
    TcpChannel,
)


@dataclass
class Recorded:
    """Settings whose channel records its arguments."""

    name: str
    log: list[str] = field(default_factory=list)
    timeout: float = 0.05
    fails: bool = False

    def open(self, network: object = None) -> Recorded:
        return self

    def begin(self, request: bytes, first: int) -> bytes:
        self.log.append(f"{self.name} begin")
        if self.fails:
            raise ChannelError(E_TMOUT, "no answer")
        return bytes(first)

    def more(self, n: int) -> bytes:
        return bytes(n)

    def end(self) -> None:
        self.log.append(f"{self.name} end")

    def reset(self) -> None:
        self.log.append(f"{self.name} reset")

    def close(self) -> None:
        self.log.append(f"{self.name} close")


def use(link: Link, settings: Any) -> None:
    link.use(settings)


def test_a_change_waits_for_the_end_of_a_call() -> None:
    log: list[str] = []
    link = Link()
    use(link, Recorded("a", log))
    assert link.begin(b"", 2) == b"\0\0"
    use(link, Recorded("b", log))
    assert link.more(3) == b"\0\0\0"
    assert log == ["a begin"]
    link.end()
    assert log == ["a begin", "a end", "a close"]
    link.begin(b"", 0)
    link.reset()
    assert log[3:] == ["b begin", "b reset"]


def test_a_change_between_calls_counts_at_once() -> None:
    log: list[str] = []
    link = Link()
    use(link, Recorded("a", log))
    use(link, Recorded("b", log))
    assert log == ["a close"]
    same = Recorded("b", log)
    use(link, same)
    assert log == ["a close"]


def test_one_call_at_a_time() -> None:
    link = Link()
    use(link, Recorded("a"))
    link.begin(b"", 0)
    found: list[ChannelError] = []

    def other() -> None:
        with pytest.raises(ChannelError) as caught:
            link.begin(b"", 0)
        found.append(caught.value)

    thread = threading.Thread(target=other)
    thread.start()
    thread.join(10.0)
    assert found[0].sub == E_TMOUT
    link.end()
    link.begin(b"", 0)


def test_a_call_that_does_not_begin_leaves_the_link_free() -> None:
    link = Link()
    with pytest.raises(ChannelError) as caught:
        link.begin(b"", 0)
    assert caught.value.sub == E_NOEXS
    use(link, Recorded("a", fails=True))
    for _ in range(2):
        with pytest.raises(ChannelError, match="no answer"):
            link.begin(b"", 0)
    with pytest.raises(ChannelError, match="no call"):
        link.more(1)


@pytest.mark.parametrize("type_", ["SERIA", "SERIAL"])
def test_a_serial_line(type_: str) -> None:
    settings = LinkSettings(type_, "none", "/dev/ttyUSB0", "9600", "none", 0.5)
    channel = settings.open()
    assert isinstance(channel, SerialChannel)
    assert (channel.device, channel.baudrate) == ("/dev/ttyUSB0", 9600)
    assert channel.timeout == 0.5


def test_tcp() -> None:
    channel = LinkSettings("TCP", "10.0.0.7", "9000", "none", "eth1", 2.0).open()
    assert isinstance(channel, TcpChannel)
    assert (channel.address, channel.port, channel.bind) == ("10.0.0.7", 9000, "eth1")


@pytest.mark.parametrize(
    ("settings", "reason"),
    [
        (LinkSettings(type="tcp"), "type is 'tcp'"),
        (LinkSettings(port="0"), "above 0"),
        (LinkSettings(port="65536"), "at most 65535"),
        (LinkSettings(port="http"), "it is a number"),
        (LinkSettings(ipaddr="none"), "ipaddr names no address"),
        (LinkSettings(timeout=0.0), "time-out"),
        (LinkSettings(type="SERIA", port="none"), "names no device"),
        (
            LinkSettings(type="SERIA", port="/dev/x", baudrate="none"),
            "baudrate is 'none'",
        ),
    ],
)
def test_settings_that_tell_no_channel(settings: LinkSettings, reason: str) -> None:
    with pytest.raises(ValueError, match=reason):
        settings.open()
