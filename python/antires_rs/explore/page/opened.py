"""Opening a page: in the browser of this computer, or inside a notebook."""

from __future__ import annotations

import sys
import time
import webbrowser
from collections.abc import Callable, Mapping
from typing import Any

from ...exceptions import AntiresError
from ..canvas import require_bokeh
from .running import Page, in_notebook
from .view import Refused, View

__all__ = ["of_set", "opened"]

#: Height of the page in a notebook, in pixels.
INLINE_PX = 820
#: For the page to say why there is nothing to see.
LAST_WORD_S = 0.5


def opened(
    make: Callable[[], View],
    title: str,
    *,
    wait: bool | None = None,
    browser: bool = True,
    say: Callable[[str], Any] = print,
) -> Page:
    """Serve a view and show it.

    Parameters
    ----------
    make : callable
        Returns the view. It is called when the browser has been told to open the page.
    title : str
        What is looked at.
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
    page = Page(ends_with_page=wait or not inline)
    page.start()
    try:
        if inline:
            _inline(page.url)
        else:
            say(f"looking at {title}: {page.url}")
            if browser and not webbrowser.open(page.url):
                say("No browser was found; open that address.")
        page.show(make())
    except BaseException as exc:
        if isinstance(exc, AntiresError):
            page.show(Refused(title, exc))
            time.sleep(LAST_WORD_S)
        page.stop()
        raise
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
    from ...signals.repeats import one_source
    from .commands import SetView
    from .session import Session

    given = dict(options)
    session = Session(
        zeros,
        None if source is None else one_source(source),
        band_hz=given.pop("band_hz", None),
        max_order=given.pop("max_order", None),
        options=given,
        save_to=save_to,
    )
    title = f"antiresonances, force at {zeros.excitation}"
    return opened(lambda: SetView(session, title), title, wait=wait, browser=browser)


def _inline(url: str) -> None:
    """The page below the cell of a notebook."""
    from IPython.display import IFrame, display

    display(IFrame(url, width="100%", height=INLINE_PX))
