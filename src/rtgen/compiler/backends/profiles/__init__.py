"""The back ends of RTC profiles and system profiles."""
