"""Parts of `rtgen run` and its relatives: a system is built, run, reported on and recorded."""
