"""What `rtgen new` makes: the first files of a project, and of its parts."""
