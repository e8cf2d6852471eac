"""Access to a CAN bus: python-can, simulated buses, the hub."""
