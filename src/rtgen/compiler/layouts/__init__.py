"""Wire layouts as data, which templates print without computing any."""
