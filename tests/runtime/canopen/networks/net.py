"""Stand-in for a generated network, filled by tests."""
