"""The island search, its checkpoints and its end."""
