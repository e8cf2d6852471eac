"""A process on a network, whose actions are given by its arguments.

It prints one line for each event, and ends with its input.
"""

from __future__ import annotations

import sys
import threading

from collecting import TOPIC, payload
from media import medium_at

from rtgen.runtime.distribution.medium import Medium, Qos, Reply
from rtgen.runtime.distribution.rpc_header import serve_octets


def publish(medium: Medium) -> None:
    """Publish samples without end, once there is a reader."""
    publisher = medium.publisher(TOPIC, Qos())
    number = 0
    pause = threading.Event()
    while not pause.wait(0.001):
        if publisher.matched:
            number += 1
            publisher.publish(payload(number))


def subscribe(medium: Medium) -> None:
    """Handle samples one by one, each acknowledged by a line."""
    medium.subscribe(TOPIC, Qos(depth=None), lambda _: say("sample"))


def hold(medium: Medium) -> None:
    """Accept requests, and reply to none."""
    replies: list[Reply] = []

    def on_request(octets: bytes, reply: Reply) -> None:
        replies.append(reply)
        say("request")

    serve_octets(medium, "s/op", on_request)


def serve(medium: Medium) -> None:
    """Reply with the request."""
    serve_octets(medium, "s/op", lambda octets, reply: reply(octets))


def announce(medium: Medium) -> None:
    """Announce its presence."""
    medium.announce("peer/1")


def say(what: str) -> None:
    """Print one line."""
    sys.stdout.write(f"{what}\n")
    sys.stdout.flush()


if __name__ == "__main__":
    address, *tasks = sys.argv[1:]
    own = medium_at(address)
    for task in tasks:
        threading.Thread(target=globals()[task], args=(own,), daemon=True).start()
    say("ready")
    sys.stdin.read()
