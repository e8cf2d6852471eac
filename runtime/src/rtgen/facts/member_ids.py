"""Member ids as hashes of names (DDS-XTypes 1.3, 7.3.1.2.1.1)."""

from __future__ import annotations

from hashlib import md5

_MEMBER_ID = 0x0FFFFFFF


def hashed_id(name: str) -> int:
    """Return the member id of a name: 28 bits of its MD5, least significant octet first."""
    digest = md5(name.encode(), usedforsecurity=False).digest()
    return int.from_bytes(digest[:4], "little") & _MEMBER_ID
