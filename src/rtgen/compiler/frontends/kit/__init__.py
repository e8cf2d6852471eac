"""Parts shared by the front ends: files, diagnostics, parser, doc comments, located texts."""
