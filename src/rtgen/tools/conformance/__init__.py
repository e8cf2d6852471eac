"""Tests of devices, boards and components against their definitions."""
