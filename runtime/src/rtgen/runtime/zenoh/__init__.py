"""Zenoh as an engine of distributed systems; needs `eclipse-zenoh` (extra `zenoh`)."""
