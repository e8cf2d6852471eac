"""Wire layouts worked out once, as data; templates print them and compute none."""
