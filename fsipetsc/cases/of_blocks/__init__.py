"""Cases in two dimensions that say blocks; they take the place of those of the same names."""
