"""The files of a small project in all languages."""

from __future__ import annotations

TYPES = """\
module Shapes {
  /// A point of the floor.
  struct Point {
    @unit("m") @max(9.0) double x;  ///< To the front.
    @unit("m") double y;
    octet quality;
    sequence<long> tags;
  };
  typedef sequence<Point> Points;
  enum Colour { RED, GREEN };
  const long MOST = 4;
};
"""

DRAWING = """\
#include "types.idl"

module Drawing {
  interface Canvas {
    void draw(in Shapes::Points points, in Shapes::Colour colour);
  };
  component Painter {
    consumes Shapes::Point where;
    publishes Shapes::Point last;
    provides Canvas canvas;
    @default(2.5) attribute double width;
  };
};
"""

SYSTEM = """\
<?xml version="1.0" encoding="UTF-8"?>
<rts:RtsProfile rts:id="RTSystem:Acme:Drawing:1.0" rts:version="0.2"
    xmlns:rts="http://www.openrtp.org/namespaces/rts"
    xmlns:rtsExt="http://www.openrtp.org/namespaces/rts_ext"
    xmlns:xsi="http://www.w3.org/2001/XMLSchema-instance">
  <rts:Components rts:instanceName="painter0" rts:id="RTC:::Painter:1.0.0"
      rts:pathUri="localhost/painter0.rtc" rts:isRequired="true">
    <rts:DataPorts rts:name="painter0.where"/>
  </rts:Components>
  <rts:Components rts:instanceName="painter1" rts:id="RTC:::Painter:1.0.0"
      rts:pathUri="localhost/painter1.rtc" rts:isRequired="true">
  </rts:Components>
  <rts:DataPortConnectors rts:connectorId="c1" rts:name="points" rts:dataType="Shapes::Point">
    <rts:sourceDataPort rts:portName="painter0.last" rts:instanceName="painter0"/>
    <rts:targetDataPort rts:portName="painter1.where" rts:instanceName="painter1"/>
  </rts:DataPortConnectors>
</rts:RtsProfile>
"""

BOARD = """\
typedef int32_t speed_t;
const int32_t SIZE = 8;

// Drives two wheels.
[deviate]
signature sMotor {
    int32_t drive([in] speed_t left, [in] speed_t right);
    int32_t name([out, string(SIZE)] char_t *text);
};

celltype tMotor {
    entry sMotor eMotor;
    attr { int32_t number = 0; };
};

[active]
celltype tTask {
    call sMotor cMotor;
};

cell tMotor Motor {
    number = SIZE;
};

cell tTask Task {
    cMotor = Motor.eMotor;
};
"""

DEVICE = """\
[FileInfo]
FileName=drive.eds
FileVersion=1
FileRevision=0
EDSVersion=4.0

[DeviceInfo]
VendorName=Acme
VendorNumber=0x1
ProductName=Drive
ProductNumber=0x2
BaudRate_125=1
BaudRate_500=1
SimpleBootUpSlave=1
Granularity=8
NrOfRXPDO=0
NrOfTXPDO=1

[MandatoryObjects]
SupportedObjects=3
1=0x1000
2=0x1001
3=0x1018

[OptionalObjects]
SupportedObjects=3
1=0x1017
2=0x1800
3=0x1A00

[ManufacturerObjects]
SupportedObjects=1
1=0x2000

[1000]
ParameterName=Device type
ObjectType=0x7
DataType=0x0007
AccessType=ro
DefaultValue=0

[1001]
ParameterName=Error register
ObjectType=0x7
DataType=0x0005
AccessType=ro

[1017]
ParameterName=Producer heartbeat time
ObjectType=0x7
DataType=0x0006
AccessType=rw
DefaultValue=100

[1018]
ParameterName=Identity object
ObjectType=0x9
SubNumber=2

[1018sub0]
ParameterName=number of entries
ObjectType=0x7
DataType=0x0005
AccessType=ro
DefaultValue=1

[1018sub1]
ParameterName=Vendor-ID
ObjectType=0x7
DataType=0x0007
AccessType=ro
DefaultValue=0x1

[1800]
ParameterName=Transmit PDO 1
ObjectType=0x9
SubNumber=3

[1800sub0]
ParameterName=number of entries
ObjectType=0x7
DataType=0x0005
AccessType=ro
DefaultValue=2

[1800sub1]
ParameterName=COB-ID
ObjectType=0x7
DataType=0x0007
AccessType=rw
DefaultValue=$NODEID+0x180

[1800sub2]
ParameterName=Transmission type
ObjectType=0x7
DataType=0x0005
AccessType=rw
DefaultValue=255

[1A00]
ParameterName=Mapping of transmit PDO 1
ObjectType=0x9
SubNumber=2

[1A00sub0]
ParameterName=number of entries
ObjectType=0x7
DataType=0x0005
AccessType=rw
DefaultValue=1

[1A00sub1]
ParameterName=first entry
ObjectType=0x7
DataType=0x0007
AccessType=rw
DefaultValue=0x20000010

[2000]
ParameterName=Speed
ObjectType=0x7
DataType=0x0003
AccessType=ro
DefaultValue=0
PDOMapping=1
"""

BUS = """\
[bus]
bit_rate = 500

[device.wheel]
eds = "drive.eds"
parameters = ["1017"]
units = { "2000" = "m/s" }

[node.left]
device = "wheel"
id = 5

[node.left.values]
"1017" = 200
"""

PROJECT = {
    "types_idl": TYPES,
    "drawing_idl": DRAWING,
    "system_xml": SYSTEM,
    "board_cdl": BOARD,
    "drive_eds": DEVICE,
    "bus_toml": BUS,
}
