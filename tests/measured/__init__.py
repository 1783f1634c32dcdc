"""What was measured: antiresonances and modes."""
