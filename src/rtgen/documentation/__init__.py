"""The pages of `rtgen docs`: a project's interfaces as Markdown, for those who use them."""
