"""Time-out of tests that wait for something. It is only reached if a test fails."""

PATIENCE = 120.0
"""In seconds; long, since a loaded machine is slow."""
