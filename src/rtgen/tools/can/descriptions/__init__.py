"""Descriptions of devices, converted between EDS, DCF, XDD and XDC, and repaired."""
