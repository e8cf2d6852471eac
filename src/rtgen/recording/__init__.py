"""Recordings of runs as MCAP files: written, read, replayed (docs/recording.md).

`mcap` is imported when a file is opened, not with this package.
"""
