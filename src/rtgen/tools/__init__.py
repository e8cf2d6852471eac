"""Tools beside the compiler: each is used from Python, and by a command."""
