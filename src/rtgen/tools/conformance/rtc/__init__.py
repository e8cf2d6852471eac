"""Tests of a running RT component against its definition."""
