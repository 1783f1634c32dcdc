"""Pictures to be explored (zoom, hover, toggle, click), and the page that shows them.

It knows results and how to show them, and computes nothing that is in no result. The figures are made by
Bokeh, whose part for browsers comes with its package: nothing is loaded from anywhere else. One file holds
one kind of figure, all stand on :mod:`~antires_rs.explore.canvas`. Uses the values that are shown and the
palette of ``plotting``.
"""
