"""Files that arrive in a folder: which of them are complete, and a wait for more."""

from __future__ import annotations

import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path
from threading import Event

from ..series.sources import is_measurement, natural

__all__ = ["Arrivals"]

#: A file that has not changed for so long is complete.
SETTLED_S = 2.0


class Arrivals:
    """The measurements of a folder, by their names; ``beside`` are files, and folders, that are none."""

    def __init__(self, folder: Path, beside: tuple[Path, ...] = ()) -> None:
        self._folder, self._beside = folder, {path.resolve() for path in beside}
        #: Whether the last look found files that still grow.
        self.growing = False

    @property
    def at_once(self) -> bool:
        """Whether the package that tells of changes is installed."""
        try:
            import watchdog  # noqa: F401 - only asked whether it is there
        except ImportError:
            return False
        return True

    def complete(self) -> list[Path]:
        """Those that have stopped changing; a test in a folder of its own counts by its latest file."""
        found, self.growing = [], False
        for path in sorted(self._folder.iterdir(), key=natural):
            if not is_measurement(path) or any(one.is_relative_to(path.resolve()) for one in self._beside):
                continue
            try:
                if time.time() - _changed(path) >= SETTLED_S:
                    found.append(path)
                else:
                    self.growing = True
            except FileNotFoundError:  # renamed while it was looked at
                self.growing = True
        return found

    @contextmanager
    def waiting(self) -> Iterator[Callable[[float], None]]:
        """A function that waits for seconds, or less if something changes and watchdog is there."""
        if not self.at_once:
            yield time.sleep
            return
        from watchdog.events import FileSystemEventHandler
        from watchdog.observers import Observer

        changed = Event()

        class Handler(FileSystemEventHandler):
            def on_any_event(self, event: object) -> None:
                changed.set()

        observer = Observer()
        observer.daemon = True
        observer.schedule(Handler(), str(self._folder), recursive=True)
        observer.start()

        def wait(seconds: float) -> None:
            # A file that grows is looked at again when it should be complete.
            if changed.wait(min(seconds, SETTLED_S) if self.growing else seconds):
                changed.clear()
                time.sleep(min(seconds, 0.5 * SETTLED_S))

        try:
            yield wait
        finally:
            observer.stop()


def _changed(path: Path) -> float:
    """When a file, or the latest in a folder, was last changed."""
    inside = [one.stat().st_mtime for one in path.iterdir()] if path.is_dir() else []
    return max([path.stat().st_mtime, *inside])
