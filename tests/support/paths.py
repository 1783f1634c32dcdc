"""Where things are in the source tree; tests run there, and from the unpacked source distribution."""

from pathlib import Path

ROOT = Path(__file__).resolve().parents[2]
DOCS = ROOT / "docs"
EXAMPLES = ROOT / "examples"
GALLERY = EXAMPLES / "gallery"
