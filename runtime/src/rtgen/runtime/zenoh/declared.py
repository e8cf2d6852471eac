"""The declarations of a Zenoh session, each undeclared once."""

from __future__ import annotations

import threading
from collections.abc import Callable
from typing import Any

import zenoh

from rtgen.runtime.failures import log
from rtgen.runtime.zenoh.session import plain


class Declared:
    """Tokens, subscribers and other declarations of a session; a `Token`.

    `end` is called once, before the declaration is withdrawn. Zenoh withdraws what nobody refers
    to, so a declaration that has to last has a keeper. Whoever uses a declaration in a thread that
    may not be the one that closes it holds `using` meanwhile, and looks at `closed` first: Zenoh
    refuses to withdraw what is in use, and to use what is being withdrawn.
    """

    def __init__(
        self,
        session: zenoh.Session,
        *declarations: Any,
        end: Callable[[], None] | None = None,
    ) -> None:
        self._session = session
        self._declarations = list(declarations)
        self._end = end
        self.using = threading.Lock()
        self.closed = False
        self._keeper: set[Declared] = set()

    def add(self, declaration: Any) -> None:
        """Withdraw this declaration, too, when this is closed."""
        self._declarations.append(declaration)

    def kept_by(self, keeper: set[Declared]) -> Declared:
        """This, which the keeper refers to until it is closed."""
        self._keeper = keeper
        keeper.add(self)
        return self

    def close(self) -> None:
        """Withdraw the declarations; those of a closed session are withdrawn already."""
        with self.using:
            if self.closed:
                return
            self.closed = True
        self._keeper.discard(self)
        if self._end is not None:
            self._end()
        while self._declarations:
            declared = self._declarations.pop()
            if self._session.is_closed():
                continue
            try:
                declared.undeclare()
            except zenoh.ZError as error:
                log.debug("zenoh: %s", plain(error))

    def matches(self, declared: Any) -> bool:
        """Return whether one of the declarations, a publisher or a querier, has a counterpart.

        Raises zenoh.ZError.
        """
        with self.using:
            return not self.closed and matches(declared)


def matches(declared: Any) -> bool:
    """Whether a publisher or querier has a counterpart. Raises zenoh.ZError."""
    # The stubs of eclipse-zenoh 1.10 call it a bool.
    return bool(declared.matching_status.matching)
