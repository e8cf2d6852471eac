"""Systems (RtsProfile): reading, checks against definitions, timelines and their measures."""
