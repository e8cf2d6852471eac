"""Back end for OpenRTM-aist-Python: a module of OpenRTM's manager for each component."""
