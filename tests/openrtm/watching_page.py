"""Stands for a page of `rtgen ui --nameserver`, without a browser."""

from __future__ import annotations

from patience import until

from rtgen.runtime import RealClock
from rtgen.tools.kit.console import Console
from rtgen.ui.commands import Commands
from rtgen.ui.outbox import Outbox
from rtgen.ui.project_systems import CommandProject
from rtgen.ui.protocol import ui
from rtgen.ui.session import Session


class Page:
    """A page of a session, which shows the components of a naming service."""

    def __init__(self, naming_service: str) -> None:
        project = CommandProject(Console("text", False, True), [])
        self.session = Session(project, "", RealClock, [naming_service])
        self.session.runner.start()
        self._commands = Commands(self.session)
        self._outbox = Outbox(lambda: None)
        self._results: list[ui.Result] = []
        self.samples: list[bytes] = []
        self.session.runner.submit(lambda: self.session.join(self._outbox))

    def done(self, branch: str, value: object) -> ui.Result:
        """Carry out a command, which succeeds."""
        result = self.result(branch, value)
        assert result.done, result.message
        return result

    def result(self, branch: str, value: object) -> ui.Result:
        """Carry out a command."""
        command = getattr(ui.Command, f"of_{branch}")(value)
        message = ui.ClientMessage(request=1, asked=command)
        self._results.clear()
        self.session.runner.submit(
            lambda: self._commands.execute(self._outbox, message)
        )
        until(lambda: self._follow() or self._results)
        [result] = self._results
        return result

    def _follow(self) -> None:
        data = self._outbox.take()
        for event in ui.ServerMessage.from_cdr(data).events if data else ():
            if event.discriminator is ui.EventKind.EVENT_RESULT:
                self._results.append(event.outcome)
            elif event.discriminator is ui.EventKind.EVENT_SAMPLES:
                self.samples += [each.data for each in event.samples]

    def found(self, end: str) -> ui.Component:
        """Wait for the component whose name has this end, and return it."""
        components = self.session.remote.components

        def names() -> list[str]:
            components = self.session.remote.components
            return [each for each in components if each.endswith(end)]

        until(names)
        components = self.session.remote.components
        return components[names()[0]]
