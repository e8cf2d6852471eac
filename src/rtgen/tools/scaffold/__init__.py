"""`rtgen new`: the first files of a project, and of its parts."""
