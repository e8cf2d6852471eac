"""`rtgen docs`: documents a project's interfaces as Markdown pages, for their users."""
