"""Recordings of runs as MCAP files: writing, reading, replaying (docs/recording.md).

`mcap` is imported lazily, when a file is opened.
"""
