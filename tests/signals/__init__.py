"""Records, responses and their spectra."""
