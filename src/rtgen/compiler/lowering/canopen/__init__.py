"""Lowers CANopen devices to types, interfaces and components."""
