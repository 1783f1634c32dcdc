"""From records to antiresonances and modes."""
