"""Errors of a CAN bus."""


class LinkError(OSError):
    """The bus is unusable: it could not be opened, is off, or its other end has gone."""
