"""TECS (CDL) to IDL and Python, and the texts of functions."""
