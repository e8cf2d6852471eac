"""Runs the components of the embedded layer on the small runtime; also for MicroPython.

Prints a line for each sample that is sent, the states at the end, and how many blocks of memory
10,000 cycles have cost (CPython). The small tree and the behaviours are on the path.
"""

import sys
from array import array

from refnav.contents_interpretation import ContentsInterpretation
from refnav.hokuyo_aist import HokuyoAist
from refnav.ucode_reader import UcodeReader
from refnav.ucode_settlement import UcodeSettlement
from refrobots import iis
from rtgen.runtime import SECOND, OutPort, System, to_cdr

BUFFER = bytearray(4096)


class Tap:
    """Receives samples as an InPort does, and prints them."""

    def __init__(self, system, name, type_):
        self.name = self.owner = name
        self.type = type_
        self.lost = 0
        self._system = system

    def take_in(self, sample):
        """Print time, port and CDR."""
        length = to_cdr(sample, BUFFER)
        print(self._system.time, self.name, bytes(BUFFER[:length]).hex())


def main():
    """Run one second at each of eight places, then cycles that are measured."""
    system = System()
    laser, reader = HokuyoAist(), UcodeReader()
    settlement, contents = UcodeSettlement(), ContentsInterpretation()
    components = (laser, reader, settlement, contents)
    for component in components:
        system.add(component)
        system.activate(component)
    system.configure(reader, "markers", "1 1 0; 2 2 0.5; ff 3 0")
    records = "1 1 0 room kitchen; 2 2 0.5 door front door"
    system.configure(settlement, "records", records)
    source = OutPort("pose", iis.TimedPose2D, "Peer0")
    source.connect(laser.pose)
    source.connect(reader.pose)
    reader.sightings.connect(settlement.sightings)
    settlement.record.connect(contents.record)
    ports = (laser.range, reader.sightings, settlement.record, contents.contents)
    for port in ports:
        port.connect(Tap(system, port.owner + "." + port.name, port.type))
    pose = iis.TimedPose2D()
    for place in range(8):
        pose.tm.sec = place
        pose.data.position.x = 0.4 * place
        source.write(pose)
        system.run((place + 1) * SECOND)
    for component in components:
        print(component.instance_name, system.state(component), system.ticks(component))
    if hasattr(sys, "getallocatedblocks"):
        for port in ports:
            port._targets.pop()
        marks = array("q", [0, 0])
        for i in range(2):
            for cycle in range(10000):
                pose.data.position.x = 0.1 * (cycle % 40)
                source.write(pose)
                system.run(system.time + SECOND // 20)
            marks[i] = sys.getallocatedblocks()
        print("blocks", marks[1] - marks[0])


main()
