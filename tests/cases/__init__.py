"""The worked cases."""
