"""Systems (RtsProfile): reading, validation, timelines and measures."""
