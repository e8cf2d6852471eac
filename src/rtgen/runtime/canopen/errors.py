"""Errors of a CAN bus."""


class LinkError(OSError):
    """The bus cannot be used: it could not be opened, is off, or its other end has gone."""
