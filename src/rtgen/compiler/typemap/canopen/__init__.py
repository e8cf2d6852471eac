"""Mapping tables of CANopen (CiA 301, CiA 402): data types, names, units and ports of devices."""
