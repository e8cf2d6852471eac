"""The end of a system: its components exit, and other actions are taken in between."""

from __future__ import annotations

import threading
from collections.abc import Callable, Iterable, Iterator, Sequence
from contextlib import contextmanager
from functools import partial

from rtgen.runtime.system import watchdog

Action = Callable[[], None]


class Closing:
    """The actions for the end of a system."""

    def __init__(self) -> None:
        self._actions: list[tuple[Action, Sequence[str]]] = []
        self._at_halt: list[Action] = []

    def at_close(self, action: Action, before: Sequence[str] = ()) -> None:
        """Call an action when the system is closed, before the components named in `before` exit.

        Actions added later are called earlier. All are called again, in another thread, if the
        system is not closed after `watchdog.PATIENCE`, since a component does not let it.
        """
        self._actions.append((action, before))

    def at_halt(self, action: Action) -> None:
        """Call an action when the system is closed and begins no further tick.

        It ends the calls that ticks wait for, with EndOfRunError; later calls are possible.
        """
        self._at_halt.append(action)

    def _end_calls(self) -> None:
        for action in self._at_halt:
            action()

    def run(
        self,
        order: Iterable[str],
        *,
        halt: Callable[[Action], None],
        let_exit: Callable[[str], None],
        close: Action,
    ) -> None:
        """Halt, let the components exit in an order with the actions in between, and close.

        `halt` is given the function that ends calls. A KeyboardInterrupt abandons a step, and is
        raised at the end.
        """
        interrupt: KeyboardInterrupt | None = None
        with self._repeated_if_late():
            steps = self._steps(order, let_exit)
            steps.insert(0, partial(halt, self._end_calls))
            for step in steps:
                try:
                    step()
                except KeyboardInterrupt as error:
                    interrupt = error
            close()
        if interrupt is not None:
            raise interrupt

    def _steps(
        self, order: Iterable[str], let_exit: Callable[[str], None]
    ) -> list[Action]:
        actions, self._actions = self._actions, []
        steps: list[Action] = []
        for instance in order:
            while actions and instance in actions[-1][1]:
                steps.append(actions.pop()[0])
            steps.append(partial(let_exit, instance))
        return steps + [action for action, _ in reversed(actions)]

    @contextmanager
    def _repeated_if_late(self) -> Iterator[None]:
        actions = [action for action, _ in reversed(self._actions)]
        if not actions:
            yield
            return

        def repeat() -> None:
            for action in actions:
                action()

        timer = threading.Timer(watchdog.PATIENCE, repeat)
        timer.daemon = True
        timer.start()
        try:
            yield
        finally:
            timer.cancel()
            timer.join()
