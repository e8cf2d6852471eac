"""Clocks of a system, locks of ports, and the network in simulated time."""
