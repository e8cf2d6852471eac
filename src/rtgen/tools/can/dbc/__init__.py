"""Describes the messages of a CANopen bus in a DBC file, the format of CANdb++ and its readers."""
