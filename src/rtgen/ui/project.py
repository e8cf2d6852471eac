"""What a session and its project tell each other: systems with their files, and failures."""

from __future__ import annotations

from collections.abc import Callable
from typing import NamedTuple

from rtgen.compiler.diagnostics import Diagnostic
from rtgen.compiler.model import System
from rtgen.runtime.failures import Failure
from rtgen.ui.documents.document import Document


class Opened(NamedTuple):
    """A system and its file; `document` is None without one."""

    profile: System
    document: Document | None


class Known(NamedTuple):
    """The name of a file, and the content that the session knows; None: there is no file."""

    file: str
    data: bytes | None


class RunWatcher(NamedTuple):
    """Functions that are called for failures of components, and events of the timeline.

    These are skipped, or they are calls of an instance, with their outcome.
    """

    failed: Callable[[Failure], None]
    skipped: Callable[[Diagnostic], None]
    called: Callable[[str, str], None]
