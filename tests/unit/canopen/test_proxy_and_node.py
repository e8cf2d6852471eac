"""A proxy against the complete slave: values of every kind by SDO, faults that the slave finds."""

from __future__ import annotations

from collections.abc import Mapping

import pytest
from device_bench import DEVICE, number_of
from device_bench import NODE_ID as NODE
from proxy_bench import Configuration, DriveProxy
from test_object_values import BOUNDARIES

from rtgen.runtime import System
from rtgen.runtime.canopen import sdo, values
from rtgen.runtime.canopen.description import Kind, ObjectNumber, ObjectValue
from rtgen.runtime.canopen.frames import MILLISECOND, Frame
from rtgen.runtime.canopen.hooks import Receiver, Sender
from rtgen.runtime.canopen.links import open_link
from rtgen.runtime.canopen.nmt import NmtState
from rtgen.runtime.canopen.node import DeviceNode
from rtgen.runtime.canopen.sdo import SdoAbort
from rtgen.runtime.canopen.simulated_bus import SimulatedCanBus
