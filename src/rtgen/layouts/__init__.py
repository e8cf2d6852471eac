"""Wire layouts as data; templates print layouts and compute none."""
