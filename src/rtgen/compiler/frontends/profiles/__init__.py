"""The front ends of RTC profiles and system profiles."""
