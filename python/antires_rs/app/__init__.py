"""The command ``antires``, and jobs: what to read, to model and to look for, in one TOML file.

``antires init`` writes a job with every key explained; ``antires update`` and ``antires damage`` carry it
out. Uses the public calls of all rooms below: a job says nothing that a call could not say. Nothing is
imported here, so that ``antires --help`` waits for no numpy.
"""
