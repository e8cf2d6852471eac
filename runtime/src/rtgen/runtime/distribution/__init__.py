"""Transports between processes: one contract of engines (`medium`), and the layers above it."""
