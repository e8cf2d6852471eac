"""rtgen: an interface compiler for robot software (IDL, CDL, EDS to Python)."""

__version__ = "0.1.0"
