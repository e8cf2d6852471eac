"""The world of OpenRTM: its back end, and components adopted from Python modules."""
