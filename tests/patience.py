"""How long tests wait for what has to happen. It only matters where it does not happen."""

PATIENCE = 120.0
"""In seconds: a loaded machine is slow."""
