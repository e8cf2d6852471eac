"""A behaviour in the file that its skeleton had once."""

from robots.components.queue import QueueBase


class Queue(QueueBase):
    """Executes nothing."""
