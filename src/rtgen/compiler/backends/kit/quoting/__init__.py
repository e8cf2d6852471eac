"""Quoting of texts for each place of each output language.

Templates use the functions as filters; a text inserted without a filter is quoted or rejected by
the language of the file (`backends.kit.rendering`). Back ends that print without templates
call the functions.
"""

from rtgen.compiler.backends.kit.quoting.code import Code, HashComment, UnquotableError

__all__ = ["Code", "HashComment", "UnquotableError"]
