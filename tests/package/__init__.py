"""What concerns the package as a whole: its face, its papers, its house rules."""
