"""The local page: a set of antiresonances to be looked at and edited, or a result to be looked at.

A small server of this computer alone (127.0.0.1, a random port, a token) hands out one page and what it
shows; :mod:`~antires_rs.explore.page.guard` says who is answered. What is clicked goes to a
:class:`~antires_rs.explore.page.session.Session`, which edits the set as its own ``drop`` and ``add`` do.
Uses the figures of ``explore``, ``identification`` to look again in another band, and tornado, which comes
with bokeh.
"""
