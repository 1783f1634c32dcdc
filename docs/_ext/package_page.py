"""The page of troubleshooting is the file of the package that ``antires explain`` reads."""

from pathlib import Path

from antires_rs.support import messages as explained

PAGE = "troubleshooting"


def _read(app, docname, source):
    if docname == PAGE:
        source[0] = Path(explained.__file__).with_name(f"{PAGE}.md").read_text(encoding="utf-8")


def setup(app):
    """Connect to the event that reads a page."""
    app.connect("source-read", _read)
    return {"parallel_read_safe": True}
