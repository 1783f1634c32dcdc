"""What every room may use and that knows none of them.

Argument checks, the declaration of options, files that are whole or absent, progress and Ctrl-C, workers,
warnings.
"""
