"""Whether data are fit for identification."""
