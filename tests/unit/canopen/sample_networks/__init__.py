"""Networks like generated ones."""
