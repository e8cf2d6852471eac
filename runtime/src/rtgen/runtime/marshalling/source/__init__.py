"""The source text of codecs, made from layouts."""
