"""Transports between processes: one contract of engines (`medium`), everything else above it."""
