"""What a `with` statement closes."""

from __future__ import annotations

from abc import ABC, abstractmethod
from typing import Self


class Closable(ABC):
    """Is closed at the end of a `with` statement."""

    @abstractmethod
    def close(self) -> None:
        """Release everything. A second call has no effect."""

    def __enter__(self) -> Self:
        return self

    def __exit__(self, *exception: object) -> None:
        self.close()
