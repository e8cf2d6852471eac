"""Shared parts of back ends: rendering of templates, quoting, text of Python and IDL."""
