"""Checks of a TECS board against the CDL of its signature (OpaqueRPC)."""
