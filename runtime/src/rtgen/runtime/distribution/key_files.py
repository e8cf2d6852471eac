"""Files that the configuration of an engine names: certificates, keys, lists of users.

The engines open them without a question: reading a pipe or a device would not end.
"""

from __future__ import annotations

import os
from pathlib import Path

from rtgen.facts.files import UnreadableError, check_file
from rtgen.runtime.distribution.medium import MediumError
from rtgen.runtime.failures import log

MAX_BYTES = 1 << 20
"""Maximum size of such a file in octets."""

_OTHERS = 0o077
"""Permissions of other users."""


def check_key_file(config: str, key: str, path: Path) -> None:
    """Check a file that the setting `key` of a configuration names. Raises MediumError.

    A private key that other users may read is reported.
    """
    try:
        check_file(path, MAX_BYTES)
    except UnreadableError as error:
        raise MediumError(f"{config}: {key}: {path} cannot be read: {error}") from error
    is_private = "private" in key.lower()
    if is_private and os.name == "posix" and path.stat().st_mode & _OTHERS:
        log.warning("%s: other users may read %s: chmod 600 %s", key, path, path)
