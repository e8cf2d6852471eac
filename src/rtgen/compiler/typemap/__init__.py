"""Mapping tables between the input languages, IDL and Python, each row with its source."""
