"""A project with a service: a hand with an interface of all kinds of values."""

from __future__ import annotations

import subprocess
import sys
from pathlib import Path

from small_systems import service_port, system_text

IDL = """
module Grips {
    enum Mode { OFF, ON };
    struct Point { double x; double y; };
    struct Job {
        string name;
        Mode how;
        sequence<Point> way;
        long grid[2][2];
        @optional double limit;
    };
    union Either switch (boolean) { case TRUE: double real; case FALSE: long whole; };
    typedef sequence<octet> Octets;
    exception Jammed { double force; Mode how; };
    interface Gripper {
        double open(in double width) raises (Jammed);
        Mode turn(in Mode how, out long turns, inout double speed);
        Job work(in Job what, in Either which, in char letter, in Octets raw, in boolean fast);
        void hold();
        oneway void kick(in octet strength);
        readonly attribute long count;
    };
};
@rtc(category="Demo", vendor="me", rate=10.0)
component Hand { provides Grips::Gripper hand; };
@rtc(category="Demo", vendor="me", rate=10.0)
component Arm { uses Grips::Gripper hand; };
"""
BEHAVIOUR = """
from grips.components.hand import HandBase
from grips import grips
from rtgen.runtime import RTC_OK


class Gripper(grips.Gripper):
    def __init__(self, hand):
        self.hand = hand

    def open(self, width):
        if width > 10.0:
            raise grips.Jammed(force=width, how=grips.Mode.ON)
        self.hand.width = width
        return width + self.hand.ticks

    def turn(self, how, speed):
        return how, 3, 2.0 * speed

    def work(self, what, which, letter, raw, fast):
        what.name += f" {which.value} {letter} {len(raw)} {fast}"
        return what

    def hold(self):
        raise KeyError("no finger")

    def kick(self, strength):
        self.hand.width = strength

    @property
    def count(self):
        return 7


class Hand(HandBase):
    width = 0.0
    ticks = 0

    def on_initialize(self):
        self.hand.set_servant(Gripper(self))
        self.observables["width"] = lambda: self.width
        return RTC_OK

    def on_execute(self, ec_id):
        self.ticks += 1
        return RTC_OK
"""


def write(folder: Path) -> None:
    """Write the project with its system `s.xml`, and generate it."""
    folder.mkdir(parents=True, exist_ok=True)
    (folder / "grips.idl").write_text(IDL)
    (folder / "rtgen.toml").write_text(
        '[sources]\npaths = ["grips.idl"]\n[output]\npackage = "grips"\nskeletons = "src"\n'
    )
    command = [sys.executable, "-m", "rtgen", "generate", "-q", "--no-cache"]
    subprocess.run(command, cwd=folder, check=True)
    (folder / "src/hand.py").write_text(BEHAVIOUR)
    link = service_port("Hand0.hand", "Arm0.hand")
    (folder / "s.xml").write_text(system_text({"Hand0": "Hand", "Arm0": "Arm"}, link))
