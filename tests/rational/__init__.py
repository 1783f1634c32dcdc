"""Rational functions fitted to curves."""
