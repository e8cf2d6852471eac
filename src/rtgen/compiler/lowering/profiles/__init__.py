"""Lowers RtcProfiles to components, with the types of the IDL files that they name."""
