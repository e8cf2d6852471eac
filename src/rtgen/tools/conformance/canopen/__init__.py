"""Checks of a CANopen node against its EDS (CiA 301)."""
