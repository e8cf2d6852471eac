"""Parts that the front ends share: files, findings, parser, doc comments, located texts."""
