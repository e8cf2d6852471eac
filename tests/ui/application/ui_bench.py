"""A session without a server: commands are executed at once, by the test's thread."""

from __future__ import annotations

import asyncio
import subprocess
import sys
import threading
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager, suppress
from pathlib import Path
from typing import Any

import pytest
from patience import PATIENCE

from rtgen import runtime
from rtgen.tools.kit.console import Console
from rtgen.tools.running.recording_options import RecordingOptions
from rtgen.ui.commands import Commands
from rtgen.ui.outbox import Outbox
from rtgen.ui.project_systems import CommandProject
from rtgen.ui.protocol import ui
from rtgen.ui.serving import Server
from rtgen.ui.session import Session

ROOT = Path(__file__).resolve().parents[3]
GOAL = ROOT / "specs/navigation/rh3_goal.xml"
MOST_TABS = 400
"""The elements of a page that Tab reaches are fewer."""
QUIET = Console("text", False, True)
WIDE, NARROW = (1440, "light"), (1024, "dark")
"""The looks of pages: width and colours."""


class Page:
    """A page: the events that it receives, and its commands."""

    def __init__(self, bench: Bench, *, full: bool = True) -> None:
        self.outbox = Outbox(lambda: None, full=full)
        self._bench = bench
        self._number = 0
        bench.session.join(self.outbox)

    def events(self) -> list[ui.Event]:
        """Return the events since the last call."""
        data = self.outbox.take()
        return list(ui.ServerMessage.from_cdr(data).events) if data else []

    def ask(self, branch: str, value: Any) -> ui.Result:
        """Send a command; return its result. Earlier events stay in `seen`."""
        self._number += 1
        asked = getattr(ui.Command, f"of_{branch}")(value)
        message = ui.ClientMessage(request=self._number, asked=asked)
        octets = message.to_cdr()
        self._bench.commands.execute(self.outbox, ui.ClientMessage.from_cdr(octets))
        self.seen = self.events()
        [result] = [e.outcome for e in self.seen if e.discriminator is RESULT]
        assert result.request == self._number
        return result

    def done(self, branch: str, value: Any) -> ui.Result:
        """Send a command that succeeds."""
        result = self.ask(branch, value)
        assert result.done, f"{result.code}: {result.message}"
        return result

    def kinds(self) -> list[ui.EventKind]:
        """Return the kinds of the events that the last command caused, except its result."""
        return [e.discriminator for e in self.seen if e.discriminator is not RESULT]


RESULT = ui.EventKind.EVENT_RESULT


class Bench:
    """A session on a system's file."""

    def __init__(
        self,
        *files: Path | str,
        clock: Any = runtime.SimulatedClock,
        buses: dict[str, Path] | None = None,
        record: Path | None = None,
        beside: str = "",
    ) -> None:
        names = [str(file) for file in files] or [str(GOAL)]
        options = RecordingOptions(None if record is None else str(record), None)
        project = CommandProject(QUIET, names, buses, recording=options)
        self.session = Session(project, names[0], clock, recording=beside)
        self.commands = Commands(self.session)

    def page(self, *, full: bool = True) -> Page:
        """Return a page that has joined."""
        return Page(self, full=full)

    def close(self) -> None:
        """Close the session, which has no thread."""
        self.session.close()


def whole(events: list[ui.Event]) -> ui.SystemState:
    """Return the state among events."""
    [found] = [e.whole for e in events if e.discriminator is ui.EventKind.EVENT_SYSTEM]
    return found


def channels(state: ui.SystemState) -> Iterator[tuple[str, ui.Channel]]:
    """Yield the channels by `INSTANCE.PORT`."""
    for channel in state.channels:
        yield f"{channel.port.instance}.{channel.port.port}", channel


@contextmanager
def serving(server: Server) -> Iterator[Server]:
    """Run a server."""
    ready = threading.Event()
    thread = threading.Thread(target=lambda: asyncio.run(server.run(ready.set)))
    thread.start()
    assert ready.wait(PATIENCE)
    yield server
    server.stop()
    thread.join(PATIENCE)
    assert not thread.is_alive()


@contextmanager
def opened(browser: Any, address: str, look: tuple[int, str] = WIDE) -> Iterator[Any]:
    """Yield a page of a server; it must report no errors."""
    width, scheme = look
    size = {"width": width, "height": 900}
    page = browser.new_page(viewport=size, color_scheme=scheme, locale="en")
    page.set_default_timeout(PATIENCE * 1000)
    complaints: list[str] = []
    page.on("pageerror", lambda error: complaints.append(str(error)))
    page.on("console", lambda said: complaints.append(said.text))
    page.goto(address)
    yield page
    page.close()
    assert complaints == [], complaints


def by_mouse(button: Any) -> None:
    """Press a button by mouse."""
    button.click()


def by_keyboard(button: Any) -> None:
    """Press a button by keyboard."""
    button.focus()
    button.page.keyboard.press("Enter")


by_both_hands = pytest.mark.parametrize(
    "press", [by_mouse, pytest.param(by_keyboard, marks=pytest.mark.nightly)]
)
"""Runs a test with each way to press a button."""


def open_menu(box: Any, press: Callable[[Any], None]) -> None:
    """Open the context menu of a component's box or of a connection that has the focus."""
    page = box.page
    menu = page.get_by_role("menu")
    if press is by_mouse:
        box.locator(".head").click(button="right")
        menu.wait_for()
        return

    def has_menu() -> bool:
        # A box that is being placed does not keep the focus.
        box.focus()
        page.keyboard.press("Shift+F10")
        return bool(menu.is_visible())

    until(page, has_menu)


def choose(page: Any, name: str, press: Callable[[Any], None]) -> None:
    """Choose an item of the menu that is open, by mouse or by arrow keys."""
    item = page.get_by_role("menuitem", name=name, exact=True)
    if press is by_mouse:
        item.click()
        return
    items = page.get_by_role("menuitem")
    items.and_(page.locator(":focus")).wait_for()
    texts = items.all_inner_texts()
    assert name in texts, texts
    for _ in range(texts.index(name)):
        page.keyboard.press("ArrowDown")
    item.and_(page.locator(":focus")).wait_for()
    page.keyboard.press("Enter")


def reach(page: Any, target: Any, key: str = "Tab") -> None:
    """Move the focus to an element by Tab, or by Shift+Tab, alone."""
    for _ in range(MOST_TABS):
        if target.evaluate("each => each === document.activeElement"):
            return
        page.keyboard.press(key)
    raise AssertionError(f"{target} is not reached by {key}")


def pick(chooser: Any, name: str, press: Callable[[Any], None]) -> None:
    """Choose an option of a select, by mouse or by arrow keys, which have no effect themselves."""
    page = chooser.page
    option = chooser.get_by_role("option", name=name, exact=True)
    if press is by_mouse:
        chooser.click()
        option.click()
        return
    value = chooser.input_value()
    options = chooser.get_by_role("option")
    focused = options.and_(page.locator(":focus"))
    chooser.focus()
    page.keyboard.press("ArrowDown")
    focused.wait_for()
    page.keyboard.press("Home")
    for _ in range(options.all_inner_texts().index(name)):
        page.keyboard.press("ArrowDown")
    option.and_(focused).wait_for()
    assert chooser.input_value() == value
    page.keyboard.press("Enter")


def select(page: Any, instance: str, view: str = "Values") -> None:
    """Select a component in one of its views; none: the overview."""
    page.get_by_role("tab", name=view, exact=True).click()
    page.get_by_role("combobox", name="Component", exact=True).select_option(instance)


def until(page: Any, condition: Callable[[], bool], patience: float = PATIENCE) -> None:
    """Wait for a condition behind the page; its events are handled meanwhile."""
    end = time.monotonic() + patience
    while not condition():
        assert time.monotonic() < end
        page.wait_for_timeout(20)


def drag(
    page: Any, box: Any, to: tuple[float, float], moved: Callable[[], bool]
) -> None:
    """Drag a box by mouse until it has moved; it may not stand still yet at the first time."""
    for patience in (10, 10, PATIENCE):
        box.hover()
        at = box.bounding_box()
        page.mouse.down()
        x, y = at["x"] + at["width"] / 2, at["y"] + at["height"] / 2
        page.mouse.move(x + to[0], y + to[1], steps=5)
        page.mouse.up()
        with suppress(AssertionError):
            return until(page, moved, patience)
    raise AssertionError("the box has not moved")


Point = tuple[float, float]


class Finger:
    """The fingers on a page: the browser's own touches, not events made by a script."""

    STEPS = 6
    PAUSE = 0.1
    """A finger that has rested for this time does not throw what it moves [s]."""

    def __init__(self, page: Any) -> None:
        self._input = page.context.new_cdp_session(page)
        self._points: tuple[Point, ...] = ()

    def _send(self, kind: str, *points: Point, later: float = 0.0) -> None:
        found = [{"x": x, "y": y, "id": i} for i, (x, y) in enumerate(points)]
        event = {"type": kind, "touchPoints": found, "timestamp": time.time() + later}
        self._input.send("Input.dispatchTouchEvent", event)
        self._points = points

    def touch(self, *points: Point) -> None:
        """Put a finger on each point."""
        self._send("touchStart", *points)

    def move(self, *points: Point) -> None:
        """Move the fingers."""
        self._send("touchMove", *points)

    def lift(self) -> None:
        """Take all fingers off, after a rest: a throw would take the next touch to stop it."""
        self._send("touchMove", *self._points, later=self.PAUSE)
        self._send("touchEnd", later=self.PAUSE)

    def pull(self, start: Point, across: float, down: float) -> None:
        """Put a finger down and move it by a way; it stays."""
        x, y = start
        self.touch(start)
        for part in (step / self.STEPS for step in range(1, self.STEPS + 1)):
            self.move((x + part * across, y + part * down))

    def drag(self, start: Point, across: float, down: float) -> None:
        """Move what is at a point by a way."""
        self.pull(start, across, down)
        self.lift()

    def pinch(self, middle: Point, before: float, after: float) -> None:
        """Move two fingers on both sides of a point to another distance."""
        x, y = middle
        self.touch((x - before, y), (x + before, y))
        for step in range(1, self.STEPS + 1):
            apart = before + (after - before) * step / self.STEPS
            self.move((x - apart, y), (x + apart, y))
        self.lift()


def centre(part: Any) -> Point:
    """Return the middle of an element of a page that does not move any more."""
    part.scroll_into_view_if_needed()
    box = part.bounding_box()
    return box["x"] + box["width"] / 2, box["y"] + box["height"] / 2


def anew(page: Any, session: Session) -> None:
    """Open the system's file again, and let time pass."""
    opened = threading.Event()

    def open_again() -> None:
        session.open(session.file)
        opened.set()

    session.runner.submit(open_again)
    until(page, opened.is_set)
    page.get_by_role("button", name="Play").click()
    page.get_by_role("button", name="Pause").wait_for()


def started_over_corba(names: str) -> subprocess.Popen[bytes]:
    """Start the system in a process of its own; its components are in a naming service.

    It does not end at its goal, which it may reach during the tests.
    """
    command = [sys.executable, "-m", "rtgen", "run", str(GOAL), "-q", "--clock", "real"]
    command += ["--transport", "corba", "--nameserver", names, "--until", "1e6"]
    return subprocess.Popen(
        command, cwd=ROOT, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL
    )
