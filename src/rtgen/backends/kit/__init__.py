"""What back ends share: rendering of templates, quoting, text of Python and of IDL."""
