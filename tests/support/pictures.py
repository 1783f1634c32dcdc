"""Pictures in a third of their time: the same lines and words, small and without a layout.

Most of a picture's time goes into room for its labels, into pixels and into what makes it explorable. How
pictures look is for the tests of plotting and of reports.
"""

from contextlib import ExitStack, contextmanager
from unittest import mock

DPI = 20


@contextmanager
def drawn_quickly(*, explored=False):
    """Within, pictures are small, and those of reports can be explored only if that is asked for."""
    try:
        from matplotlib.figure import Figure

        from antires_rs.figures import report_parts
    except ImportError:
        yield
        return
    save = Figure.savefig

    def quickly(figure, *args, **options):
        figure.set_layout_engine("none")
        return save(figure, *args, **(options | {"dpi": DPI}))

    with ExitStack() as patches:
        patches.enter_context(mock.patch.object(Figure, "savefig", quickly))
        if not explored:
            patches.enter_context(mock.patch.object(report_parts, "packed", return_value=""))
        yield
