"""Declarations of C headers that CDL files import."""
