"""Shows the current stage and file on a terminal, during long runs."""

from __future__ import annotations

from dataclasses import dataclass
from threading import Lock, Timer
from typing import TYPE_CHECKING

from rtgen.compiler.kit.translation import listed, translated_word

if TYPE_CHECKING:
    from rich.live import Live
    from rich.spinner import Spinner


@dataclass(slots=True)
class _Stage:
    name: str
    file: str = ""


class StageProgress:
    """Shows the line from `after` [s] after the start, and only within stages.

    Outside of stages, other output is possible. `close` ends it.
    """

    def __init__(self, after: float) -> None:
        self._open: list[_Stage] = []
        self._lock = Lock()
        self._due = after <= 0
        self._live: Live | None = None
        self._timer = Timer(after, self._become_due)
        self._timer.daemon = True
        if not self._due:
            self._timer.start()

    def close(self) -> None:
        """Stop showing the line."""
        self._timer.cancel()
        with self._lock:
            self._due = False
            self._hide()

    def begin(self, stage: str) -> None:
        """See `stages.Observer`."""
        with self._lock:
            self._open.append(_Stage(stage))
            self._show()

    def end(self) -> None:
        """See `stages.Observer`."""
        with self._lock:
            self._open.pop()
            if not self._open:
                self._hide()

    def file(self, name: str) -> None:
        """See `stages.Observer`."""
        if self._open:
            self._open[-1].file = name

    def note(self, _: str) -> None:
        """See `stages.Observer`."""

    def text(self) -> str:
        """Return the current stages, outermost first, and the current file."""
        stages = list(self._open)
        files = [stage.file for stage in stages if stage.file]
        text = listed(translated_word(stage.name) for stage in stages)
        text = "  ".join((text, *files[-1:]))
        return "".join(c if c.isprintable() else "?" for c in text)

    def _become_due(self) -> None:
        with self._lock:
            self._due = True
            self._show()

    def _show(self) -> None:
        if not self._due or not self._open or self._live is not None:
            return
        from rich.console import Console
        from rich.live import Live
        from rich.spinner import Spinner

        console = Console(stderr=True)
        if not console.is_interactive:
            self._due = False
            return
        spinner = Spinner("line")
        self._live = Live(
            console=console,
            transient=True,
            redirect_stdout=False,
            redirect_stderr=False,
            get_renderable=lambda: self._line(spinner),
        )
        self._live.start(refresh=True)

    def _hide(self) -> None:
        if self._live is not None:
            self._live.stop()
            self._live = None

    def _line(self, spinner: Spinner) -> Spinner:
        from rich.text import Text

        spinner.text = Text(self.text(), no_wrap=True, overflow="crop")
        return spinner
