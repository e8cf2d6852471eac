"""The clocks of a system, the locks of ports and the network in simulated time."""
