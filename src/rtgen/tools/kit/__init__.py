"""What all tools use: the console, exit codes, signals."""
