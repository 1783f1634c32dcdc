"""Opening a page: in the browser of this computer, or inside a notebook."""

from __future__ import annotations

import sys
import time
import webbrowser
from collections.abc import Callable, Mapping, Sequence
from dataclasses import asdict, dataclass
from functools import cache
from typing import TYPE_CHECKING, Any

from ..exceptions import AntiresError, reject
from ..signals.repeats import one_source
from .live_canvas import item, require_bokeh
from .page_server import Page, in_notebook
from .page_session import Session, SetView, View

if TYPE_CHECKING:
    from .report_parts import Figure

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
    """Serve a view and show it."""
    inline = in_notebook()
    wait = not inline if wait is None else wait
    page = Page(ends_with_page=wait or not inline)
    page.start()
    try:
        if inline:
            from IPython.display import IFrame, display

            display(IFrame(page.url, width="100%", height=INLINE_PX))
        else:
            say(f"looking at {title}: {page.url}")
            if browser and not webbrowser.open(page.url):
                say("No browser was found; open that address.")
        page.show(make())
    except BaseException as exc:
        if isinstance(exc, AntiresError):
            page.show(View(title, exc))
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


# -- The page of a result: its figures, its answer and its tables; nothing can be changed there


@dataclass(frozen=True)
class Table:
    """Heads and rows as text; heads with a unit are those of numbers."""

    title: str
    head: tuple[str, ...]
    rows: list[list[str]]


class ResultView(View):
    """A result: its answer, of which the first sentence is large, figures and tables."""

    def __init__(
        self, title: str, answer: Sequence[str], figures: Sequence[Figure], tables: Sequence[Table]
    ) -> None:
        super().__init__(title)
        self.answer, self.figures, self.tables = answer, figures, tables
        self._item = cache(lambda shown: item(self.figures[shown].explore()))

    def state(self, shown: int) -> dict[str, Any]:
        """Everything but the figures."""
        return {
            "kind": "result",
            "answer": list(self.answer),
            "figures": [{"caption": one.caption} for one in self.figures],
            "tables": [asdict(one) for one in self.tables],
        }

    def figure(self, shown: int) -> dict[str, Any]:
        """One of the figures."""
        if not 0 <= shown < len(self.figures):
            reject("shown", shown, f"a figure from 0 to {len(self.figures) - 1}", "Load the page again.")
        return dict(self._item(shown))
