"""Networks as they are generated."""
