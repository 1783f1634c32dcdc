"""The command ``antires``, and jobs: what to read, to model and to look for, in one TOML file.

A job says nothing that a call could not say. Nothing is imported here, so that ``antires --help`` waits for
no numpy.
"""
