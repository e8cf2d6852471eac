"""Cost of pages of `rtgen ui` for a run: 60 components, 200 connections, 50 ports at 100 Hz.

    python benchmarks/ui.py [--seconds S] [--browser CHROMIUM]

A system in real time without a page, with one that reads, with one that reads nothing, and with one
of each. `ticks` are those of all components and those that were due; `overruns` and `lost` are
counted by the runtime; `samples` are those that the reading page received and those that were
written, `less` those reported to it as omitted.

With `--browser` the built page is open in that browser, headless and without a GPU: its frames
per second, of the wiring alone, while it is panned, and with a map that watches all ports, whose
samples it draws. `empty` is a page with nothing but the loop that counts frames: what the browser
and the load of the machine leave. The second table has the first view, by a browser that has no
cache: from the request of the page until all boxes and connections are in their places. `browser`
and `server` are the processor time of their processes, of the page's main thread `main`; unlike
`view`, the load of the machine hardly changes them. `nothing` is an answer of the same server
without a page. `arranged before`: the server has stored how an earlier page arranged the wiring.
The least of several rounds.
"""

from __future__ import annotations

import asyncio
import sys
import threading
import time
from collections.abc import Callable, Sequence
from contextlib import ExitStack
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any

from tables import Arguments, Results, Table

HERE = Path(__file__).parent
sys.path.insert(0, str(HERE.parent / "generated"))

from websockets.exceptions import ConnectionClosed  # noqa: E402
from websockets.sync.client import ClientConnection, connect  # noqa: E402

from refrobots import rtc  # noqa: E402
from rtgen import runtime  # noqa: E402
from rtgen.compiler.model import System, SystemComponent  # noqa: E402
from rtgen.compiler.systems.timeline import Timeline  # noqa: E402
from rtgen.runtime.rtc.profiles import ComponentProfile  # noqa: E402
from rtgen.tools.kit.console import Console  # noqa: E402
from rtgen.ui.arrangements import Arrangements  # noqa: E402
from rtgen.ui.bus_description import BusDescriber  # noqa: E402
from rtgen.ui.project import Known, Opened, RunWatcher  # noqa: E402
from rtgen.ui.project_systems import CommandProject  # noqa: E402
from rtgen.ui.protocol import ui  # noqa: E402
from rtgen.ui.serving import Server  # noqa: E402
from rtgen.ui.session import Session  # noqa: E402

COMPONENTS, WRITERS, CONNECTIONS, RATE = 60, 50, 200, 100.0


class Node(runtime.Component, type_name="Node", rate=RATE):
    """Writes a sample each tick, if it is a writer, and reads what it received."""

    heard = runtime.inport(rtc.TimedPose2D)
    said = runtime.outport(rtc.TimedPose2D)

    def __init__(self, name: str, *, writes: bool) -> None:
        super().__init__(name)
        self.writes = writes
        self.written = 0

    def on_execute(self, ec_id: int) -> runtime.ReturnCode_t:
        """Read everything, write one sample."""
        while self.heard.is_new():
            self.heard.read()
        if self.writes:
            self.written += 1
            self.said.write(rtc.TimedPose2D())
        return runtime.RTC_OK


class Network:
    """The project of a session, with a system that is constructed instead of read."""

    systems: Sequence[str] = ("network",)

    def read(self, file: str) -> Opened:
        """Return an empty profile."""
        profile = System(
            name=file, id="", file=file, abstract="", components=(), connections=()
        )
        return Opened(profile, None)

    def write(self, file: str, data: bytes, own: Known, *, replace: bool) -> str:
        """Do nothing."""
        return ""

    def timeline(self, profile: System) -> Timeline:
        """Return one without events."""
        return Timeline()

    def refusals(self, profile: System) -> Sequence[str]:
        """Return nothing: no file is run."""
        return ()

    def report_end(self, reason: str) -> None:
        """Do nothing."""

    def add(
        self, system: runtime.System, component: SystemComponent, folder: Path
    ) -> None:
        """Do nothing."""

    def describer(self, bus: str, network: str) -> BusDescriber:
        """Return nothing to describe: there is no bus."""
        raise LookupError(bus)

    def record(self, system: runtime.System) -> Callable[[], None]:
        """Record nothing."""
        return lambda: None

    def data_type(self, name: str) -> None:
        """No other process is looked at."""

    def interface(self, name: str) -> None:
        """No other process is looked at."""

    def palette(self) -> Sequence[ComponentProfile]:
        """No types."""
        return ()

    def assemble(
        self, profile: System, clock: runtime.Clock, watcher: RunWatcher
    ) -> runtime.System:
        """Return the components, each writer connected with four others."""
        system = runtime.System(clock)
        for i in range(COMPONENTS):
            system.add(Node(f"Node{i}", writes=i < WRITERS))
        for i in range(CONNECTIONS):
            writer, step = i % WRITERS, 1 + i // WRITERS
            reader = (writer + 7 * step) % COMPONENTS
            properties = {"dataport.inport.buffer.length": "256"}
            system.connect(
                (f"Node{writer}", "said"), (f"Node{reader}", "heard"), properties
            )
        for instance in system.instances:
            system.activate(instance)
        return system


class Reader:
    """A page that reads all, and counts."""

    def __init__(self, socket: ClientConnection) -> None:
        self.samples = self.less = self.octets = 0
        self._socket = socket
        self._thread = threading.Thread(target=self._read)
        self._thread.start()

    def _read(self) -> None:
        try:
            for data in self._socket:
                self.octets += len(data)
                message = ui.ServerMessage.from_cdr(data)  # type: ignore[arg-type]
                for event in message.events:
                    if event.discriminator is ui.EventKind.EVENT_SAMPLES:
                        self.samples += len(event.samples)
                    elif event.discriminator is ui.EventKind.EVENT_SENT_LESS:
                        self.less += event.less.dropped
        except ConnectionClosed:
            return

    def join(self) -> None:
        """Wait until the socket is closed."""
        self._thread.join()


def watch(socket: ClientConnection) -> None:
    """Ask for the samples of all channels."""
    numbers = list(range(1, COMPONENTS + 1))
    message = ui.ClientMessage(asked=ui.Command.of_channels(numbers))
    socket.send(message.to_cdr())


def measure(seconds: float, *, reads: bool, stalls: bool) -> dict[str, Any]:
    """Return one run with these pages."""
    session = Session(Network(), "network", runtime.RealClock)
    server = Server(session, "127.0.0.1", 0)
    ready = threading.Event()
    serving = threading.Thread(target=lambda: asyncio.run(server.run(ready.set)))
    serving.start()
    ready.wait()
    reader = None
    address = (
        server.address(full=True).replace("http:", "ws:").replace("/?", "/socket?")
    )
    with ExitStack() as pages:
        if reads:
            page = pages.enter_context(connect(address, max_size=None))
            watch(page)
            reader = Reader(page)
        if stalls:
            lazy = connect(address, max_size=None, max_queue=1, close_timeout=0.1)
            watch(pages.enter_context(lazy))
        nodes: list[Any] = [
            session.system.component(name) for name in session.system.instances
        ]
        session.runner.submit(session.runner.play)
        begun, processor = time.monotonic(), time.process_time()
        time.sleep(seconds)
        passed = time.monotonic() - begun
        used = (time.process_time() - processor) / passed
        counts = [session.system.statistics(name) for name in session.system.instances]
        written = sum(node.written for node in nodes)
        time.sleep(0.2)
    if reader is not None:
        reader.join()
    server.stop()
    serving.join()
    return {
        "ticks": f"{sum(c.ticks for c in counts)} of {COMPONENTS * RATE * passed:.0f}",
        "overruns": sum(c.overruns for c in counts),
        "lost": sum(c.lost for c in counts),
        "samples": "" if reader is None else f"{reader.samples} of {written}",
        "less": "" if reader is None else reader.less,
        "MB/s": "" if reader is None else f"{reader.octets / passed / 1e6:.2f}",
        "processor": f"{used:.2f}",
    }


_FRAMES = """(seconds) => {
    window.frames_of = (async () => {
        let frames = 0, longest = 0, before = performance.now();
        const begun = before;
        while (before < begun + seconds * 1000) {
            const now = await new Promise(requestAnimationFrame);
            longest = Math.max(longest, now - before);
            before = now;
            frames += 1;
        }
        return [frames / ((before - begun) / 1000), longest];
    })();
}"""
_FIRST_VIEW = """() => {
    window.first_view = new Promise((seen) => {
      const look = () => {
        const wiring = document.querySelector(".wiring[aria-busy=false]:not(.unplaced)");
        if (wiring?.querySelector(".react-flow__edge") || !document.querySelector("script")
            && document.readyState === "complete") {
            seen(performance.now());
        } else requestAnimationFrame(look);
      };
      look();
    });
}"""
_STEP = 1 / 60
"""Time between two movements of the mouse [s]."""


def frames(
    page: Any, seconds: float, act: Callable[[float], None]
) -> tuple[float, float]:
    """Return frames per second, and the longest one [ms], while something is done until a time."""
    page.evaluate(_FRAMES, seconds)
    act(time.monotonic() + seconds)
    rate, longest = page.evaluate("window.frames_of")
    return rate, longest


def pan(page: Any, end: float) -> None:
    """Drag the wiring to and fro until a time."""
    box = page.locator(".react-flow__pane").bounding_box()
    x, y = box["x"] + 8, box["y"] + 8
    page.mouse.move(x, y)
    page.mouse.down()
    step = 0
    while time.monotonic() < end:
        way = abs(step % 120 - 60)
        page.mouse.move(x + 4 * way, y + 2 * way)
        step += 1
        time.sleep(_STEP)
    page.mouse.up()


def wait(page: Any, end: float) -> None:
    """Do nothing until a time."""
    page.wait_for_timeout(1000 * max(end - time.monotonic(), 0.0))


def browse(program: str, seconds: float) -> dict[str, dict[str, Any]]:
    """Return the frame rates of the page in a browser, and the losses of the run meanwhile."""
    from playwright.sync_api import sync_playwright

    session = Session(Network(), "network", runtime.RealClock)
    server = Server(session, "127.0.0.1", 0)
    ready = threading.Event()
    serving = threading.Thread(target=lambda: asyncio.run(server.run(ready.set)))
    serving.start()
    ready.wait()
    rows: dict[str, dict[str, Any]] = {}
    with sync_playwright() as driver:
        browser = driver.chromium.launch(executable_path=program, args=["--no-sandbox"])

        def measured(title: str, page: Any, act: Callable[[Any, float], None]) -> None:
            before = [session.system.statistics(n) for n in session.system.instances]
            rate, longest = frames(page, seconds, lambda end: act(page, end))
            after = [session.system.statistics(n) for n in session.system.instances]
            pairs = [*zip(before, after, strict=True)]
            rows[title] = {
                "frames/s": f"{rate:.1f}",
                "longest": f"{longest:.0f} ms",
                "ticks/s": f"{sum(b.ticks - a.ticks for a, b in pairs) / seconds:.0f}",
                "overruns": sum(b.overruns - a.overruns for a, b in pairs),
                "lost": sum(b.lost - a.lost for a, b in pairs),
            }

        size = {"width": 1440, "height": 900}
        session.runner.submit(session.runner.play)
        empty = browser.new_page(viewport=size)
        measured("empty", empty, wait)
        empty.close()
        page = browser.new_page(viewport=size, locale="en-US")
        page.goto(server.address(full=True))
        page.locator(".wiring[aria-busy=false] .react-flow__edge").first.wait_for()
        for tab, title in (("Values", "wiring"), ("Map", "wiring, map of all ports")):
            page.get_by_role("tab", name=tab).click()
            page.wait_for_timeout(1000)
            measured(title, page, wait)
            measured(f"{title}, panned", page, pan)
        browser.close()
    server.stop()
    serving.join()
    return rows


def _processor(browser: Any) -> float:
    """Return the processor time of the processes that draw pages [s]."""
    answer = browser.new_browser_cdp_session().send("SystemInfo.getProcessInfo")
    processes = answer["processInfo"]
    return float(sum(e["cpuTime"] for e in processes if e["type"] == "renderer"))


def first_view(
    program: str, session: Session, path: str, arrangements: Arrangements | None
) -> dict[str, float]:
    """Return what the first view of a page costs, or that of another path of the server."""
    from playwright.sync_api import sync_playwright

    server = Server(session, "127.0.0.1", 0, arrangements=arrangements)
    ready = threading.Event()
    serving = threading.Thread(target=lambda: asyncio.run(server.run(ready.set)))
    serving.start()
    ready.wait()
    address = f"http://127.0.0.1:{server.port}/{path}"
    with sync_playwright() as driver:
        browser = driver.chromium.launch(executable_path=program, args=["--no-sandbox"])
        page = browser.new_page(viewport={"width": 1440, "height": 900}, locale="en-US")
        page.add_init_script(f"({_FIRST_VIEW})()")
        loaded: list[int] = []
        page.on(
            "response",
            lambda each: loaded.append(int(each.headers.get("content-length", 0))),
        )
        devtools = page.context.new_cdp_session(page)
        devtools.send("Performance.enable")
        before, own = _processor(browser), time.process_time()
        page.goto(address if path else server.address(full=True))
        view = page.evaluate("window.first_view")
        own = time.process_time() - own
        metrics = devtools.send("Performance.getMetrics")["metrics"]
        [main] = [each["value"] for each in metrics if each["name"] == "TaskDuration"]
        spent = _processor(browser) - before
        if arrangements:
            page.wait_for_load_state("networkidle")  # until it is stored
        browser.close()
    server.stop()
    serving.join()
    return {
        "view [ms]": view,
        "browser [ms]": 1000 * spent,
        "main [ms]": 1000 * main,
        "server [ms]": 1000 * own,
        "requests": len(loaded),
        "kB": sum(loaded) / 1000,
    }


def first_views(program: str, rounds: int, folder: Path) -> dict[str, dict[str, str]]:
    """Return the first views of nothing, of a small and of a large system.

    What is arranged before is stored in a folder by a first round, which does not count.
    """
    goal = HERE.parent / "specs/navigation/rh3_goal.xml"

    def small() -> Session:
        project = CommandProject(Console("text", False, True), [str(goal)], None)
        return Session(project, str(goal), runtime.SimulatedClock)

    def large() -> Session:
        return Session(Network(), "network", runtime.SimulatedClock)

    kinds: dict[str, tuple[Callable[[], Session], str, Arrangements | None]] = {
        "nothing": (large, "assets/none", None),
        "rh3_goal, 6 components": (small, "", None),
        "60 components, 200 connections": (large, "", None),
        "the same, arranged before": (large, "", Arrangements(folder)),
    }
    found = [
        {
            title: first_view(program, session(), path, arrangements)
            for title, (session, path, arrangements) in kinds.items()
        }
        for _ in range(1 + rounds)
    ][1:]
    return {
        title: {
            name: f"{min(each[title][name] for each in found):.0f}" for name in columns
        }
        for title, columns in found[0].items()
    }


def show(table: Table, rows: dict[str, dict[str, Any]]) -> None:
    """Fill a table with rows."""
    for title, row in rows.items():
        table.add(title, *(str(cell) for cell in row.values()))


def main() -> None:
    """Print a row for each combination of pages."""
    parser = Arguments(__doc__, rounds=5)
    parser.add_argument("--seconds", type=float, default=10.0)
    parser.add_argument("--browser", metavar="CHROMIUM")
    chosen = parser.parse_args()
    seconds = 0.5 if chosen.smallest else chosen.seconds
    with Results(__file__, chosen) as results:
        if chosen.browser:
            found = browse(chosen.browser, seconds)
        else:
            found = {
                "no page": measure(seconds, reads=False, stalls=False),
                "one that reads": measure(seconds, reads=True, stalls=False),
                "one that does not": measure(seconds, reads=False, stalls=True),
                "one of each": measure(seconds, reads=True, stalls=True),
            }
        columns = [(name, "s") for name in next(iter(found.values()))]
        name = "pages" if chosen.browser else "readers"
        show(results.table(name, "page", *columns), found)
        if chosen.browser:
            with TemporaryDirectory() as folder:
                views = first_views(chosen.browser, chosen.rounds, Path(folder))
            columns = [(name, "s") for name in next(iter(views.values()))]
            show(results.table("first_views", "first view", *columns), views)


if __name__ == "__main__":
    main()
