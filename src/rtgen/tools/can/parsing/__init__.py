"""Parses frames and values as users write them, sequences of frames, and bus logs."""
