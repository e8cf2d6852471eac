"""Reads the declarations in C headers that CDL files import."""
