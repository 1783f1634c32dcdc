"""Reports of one file."""
