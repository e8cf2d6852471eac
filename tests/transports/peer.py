"""A process of its own on a network; what it does is given by its arguments.

It prints one line for each thing that has happened, and ends when its input does.
"""

from __future__ import annotations

import sys
import threading

from collecting import TOPIC, payload
from media import medium_at

from rtgen.runtime.distribution.medium import Medium, Qos, Reply
from rtgen.runtime.distribution.rpc_header import serve_octets


def publish(medium: Medium) -> None:
    """Samples without end, as soon as somebody reads them."""
    publisher = medium.publisher(TOPIC, Qos())
    number = 0
    pause = threading.Event()
    while not pause.wait(0.001):
        if publisher.matched:
            number += 1
            publisher.publish(payload(number))


def subscribe(medium: Medium) -> None:
    """Handles samples one by one, each acknowledged by a line."""
    medium.subscribe(TOPIC, Qos(depth=None), lambda _: say("sample"))


def hold(medium: Medium) -> None:
    """Takes requests, and replies to none."""
    replies: list[Reply] = []

    def on_request(octets: bytes, reply: Reply) -> None:
        replies.append(reply)
        say("request")

    serve_octets(medium, "s/op", on_request)


def serve(medium: Medium) -> None:
    """Replies with what it gets."""
    serve_octets(medium, "s/op", lambda octets, reply: reply(octets))


def announce(medium: Medium) -> None:
    """Is present."""
    medium.announce("peer/1")


def say(what: str) -> None:
    """One line."""
    sys.stdout.write(f"{what}\n")
    sys.stdout.flush()


if __name__ == "__main__":
    address, *tasks = sys.argv[1:]
    own = medium_at(address)
    for task in tasks:
        threading.Thread(target=globals()[task], args=(own,), daemon=True).start()
    say("ready")
    sys.stdin.read()
