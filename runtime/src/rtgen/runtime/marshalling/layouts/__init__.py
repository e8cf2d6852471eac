"""From descriptors to layouts: the position of each value in CDR and XCDR, as data."""
