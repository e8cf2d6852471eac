"""Parts of commands that compile definitions: the cache, one run, watching, progress."""
