"""The other end of CANopen devices: managers (NMT master, SDO client) and proxies."""
