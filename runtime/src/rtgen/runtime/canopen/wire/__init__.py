"""CANopen on the wire (CiA 301, CiA 305): frames and protocol machines without I/O or a clock."""
