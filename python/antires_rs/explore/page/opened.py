"""Opening a page: in the browser of this computer, or inside a notebook."""

from __future__ import annotations

import sys
import webbrowser
from collections.abc import Callable, Mapping
from typing import Any

from ...signals.repeats import one_source
from ..canvas import require_bokeh
from .commands import SetView, View
from .running import Page, in_notebook
from .session import Session

__all__ = ["of_set", "opened"]

#: Height of the page in a notebook, in pixels.
INLINE_PX = 820


def opened(
    view: View, *, wait: bool | None = None, browser: bool = True, say: Callable[[str], Any] = print
) -> Page:
    """Serve a view and show it.

    Parameters
    ----------
    view : View
    wait : bool, optional
        Return when the page was closed, or Ctrl-C; by default everywhere but in a notebook, which shows the
        page below the cell and goes on.
    browser : bool
        Open it; else its address is told only.
    say : callable
        Receives the lines that are told.

    Raises
    ------
    MissingDependencyError
        bokeh is not installed.
    """
    inline = in_notebook()
    wait = not inline if wait is None else wait
    page = Page(view, ends_with_page=wait or not inline)
    page.start()
    if inline:
        _inline(page.url)
    else:
        say(f"looking at {view.title}: {page.url}")
        if browser and not webbrowser.open(page.url):
            say("No browser was found; open that address.")
    if wait:
        try:
            page.wait()
        except KeyboardInterrupt:
            print(file=sys.stderr)
        finally:
            kept = page.keep_unsaved()
            if kept is not None:
                say(f"Edits that were not saved are in {kept}")
    return page


def of_set(
    zeros: Any, source: Any, save_to: Any, options: Mapping[str, Any], *, wait: bool | None, browser: bool
) -> Page:
    """What :meth:`~antires_rs.AntiresonanceSet.look` does."""
    require_bokeh()
    given = dict(options)
    session = Session(
        zeros,
        None if source is None else one_source(source),
        band_hz=given.pop("band_hz", None),
        max_order=given.pop("max_order", None),
        options=given,
        save_to=save_to,
    )
    return opened(
        SetView(session, f"antiresonances, force at {zeros.excitation}"), wait=wait, browser=browser
    )


def _inline(url: str) -> None:
    """The page below the cell of a notebook."""
    from IPython.display import IFrame, display

    display(IFrame(url, width="100%", height=INLINE_PX))
