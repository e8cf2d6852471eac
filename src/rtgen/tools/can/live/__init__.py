"""Runs protocols on an open bus: frames as they arrive, SDO, LSS, scans."""
