"""Take the folders of the building machine out of a wheel's bill of materials, and look for others.

The bill of materials (CycloneDX, in ``.dist-info/sboms/``) names the crates of this repository by their
absolute path; what stays of it is the path inside the repository. With ``--strict`` a folder left anywhere in
the wheel is an error.

    python .ci/tidy_wheel.py [--strict] dist/*.whl
"""

import argparse
import base64
import csv
import hashlib
import io
import os
import re
import sys
import zipfile
from pathlib import Path

#: From an absolute path to the one inside the repository.
CRATE = re.compile(rb'path\+file://[^"]*?/(rust/antires-)')


def tidy(wheel: Path) -> list[str]:
    """Rewrite one wheel in place; returns what of this machine is still inside."""
    with zipfile.ZipFile(wheel) as archive:
        members = [(info, archive.read(info)) for info in archive.infolist()]
    bills = [info.filename for info, _ in members if "/sboms/" in info.filename]
    if not bills:
        sys.exit(f"{wheel.name}: no bill of materials inside; maturin of at least 1.12 writes one")
    content = {
        info.filename: CRATE.sub(rb"\1", data) if info.filename in bills else data for info, data in members
    }
    new = wheel.with_suffix(".tmp")
    with zipfile.ZipFile(new, "w", zipfile.ZIP_DEFLATED) as archive:
        for info, data in members:
            record = info.filename.endswith(".dist-info/RECORD")
            archive.writestr(info, recorded(data, content) if record else content[info.filename])
    new.replace(wheel)
    print(f"{wheel.name}: {', '.join(bills)}")
    return [
        f"{wheel.name}: {name} contains {folder}"
        for folder in folders()
        for name, data in content.items()
        if f"{folder}{os.sep}".encode() in data or folder.as_uri().encode() + b"/" in data
    ]


def folders() -> list[Path]:
    """What no wheel should tell: where it was built, and by whom."""
    home = Path.home()
    cargo = Path(os.environ.get("CARGO_HOME", home / ".cargo"))
    return sorted({Path(__file__).resolve().parents[1], home, cargo} - {Path(home.anchor)})


def recorded(record: bytes, content: dict[str, bytes]) -> bytes:
    """RECORD with checksums and sizes of the files as they are now."""
    out = io.StringIO()
    rows = csv.writer(out, lineterminator="\n")
    for name, checksum, size in csv.reader(record.decode().splitlines()):
        if checksum:
            digest = base64.urlsafe_b64encode(hashlib.sha256(content[name]).digest()).rstrip(b"=").decode()
            checksum, size = f"sha256={digest}", str(len(content[name]))
        rows.writerow([name, checksum, size])
    return out.getvalue().encode()


if __name__ == "__main__":
    arguments = argparse.ArgumentParser()
    arguments.add_argument("--strict", action="store_true")
    arguments.add_argument("wheels", nargs="+", type=Path)
    given = arguments.parse_args()
    left = [line for wheel in given.wheels for line in tidy(wheel)]
    print(*left, sep="\n", end="\n" if left else "")
    sys.exit(1 if left and given.strict else 0)
