"""What every room may use and that knows none of them: argument checks, progress, pickling, files.

Uses: :mod:`antires_rs.exceptions`, numpy. Knows nothing of signals or structures.

- ``validation``: one check for each kind of argument, with one sentence pattern for refusals
- ``progress``: the progress line, and calls into the core that Ctrl-C can leave
- ``pickling``: read-only arrays, and objects that are made again from what they were made of
- ``files``: files that are whole or not there at all
"""
