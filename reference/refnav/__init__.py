"""Behaviours of the reference applications, written by hand on generated base classes."""
