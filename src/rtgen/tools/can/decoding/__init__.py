"""Decodes CANopen frames, and prints them as text, JSON, tables and diagrams."""
