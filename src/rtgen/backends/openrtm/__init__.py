"""Back end for OpenRTM-aist-Python: a module for its manager for each component."""
