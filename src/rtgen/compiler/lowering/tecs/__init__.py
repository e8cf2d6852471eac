"""Lowers CDL files with joins through `RTCPlugin` to packages of interfaces and components."""
