"""Mend blanks at the ends of lines and files: ``python .ci/end_of_file.py FILE ...``; exit code 1 if any."""

import sys
from pathlib import Path


def mended(text: str) -> str:
    """Text without blanks at line ends, with one newline at its end; empty text stays empty."""
    lines = [line.rstrip(" \t") for line in text.split("\n")]
    while lines and not lines[-1]:
        lines.pop()
    return "".join(f"{line}\n" for line in lines)


def main(names: list[str]) -> int:
    """Mend the files; a hook fails if it has changed something."""
    changed = 0
    for name in names:
        text = Path(name).read_bytes().decode("utf-8")
        if mended(text) != text:
            Path(name).write_bytes(mended(text).encode("utf-8"))
            print(f"mended {name}")
            changed += 1
    return int(changed > 0)


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
