"""Calls of TECS boards: values as JSON, octets, simulated boards."""
