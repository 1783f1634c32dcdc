"""Pictures in a third of their time: the same lines and words, small and without a layout.

Most of a picture's time goes into room for its labels and into pixels. How pictures look is for the tests of
plotting and of reports.
"""

from contextlib import contextmanager
from unittest import mock

DPI = 20


@contextmanager
def drawn_quickly():
    try:
        from matplotlib.figure import Figure
    except ImportError:
        yield
        return
    save = Figure.savefig

    def quickly(figure, *args, **options):
        figure.set_layout_engine("none")
        return save(figure, *args, **(options | {"dpi": DPI}))

    with mock.patch.object(Figure, "savefig", quickly):
        yield
