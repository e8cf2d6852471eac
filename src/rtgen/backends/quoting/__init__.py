"""How text gets into files: one way of quoting for each place of each output language.

Templates have the functions as filters, and what they insert without one is quoted or refused by
the language of their file (`rtgen.backends.rendering`). Back ends that print without templates
call the functions.
"""

from rtgen.backends.quoting.code import Code, HashComment, UnquotableError

__all__ = ["Code", "HashComment", "UnquotableError"]
