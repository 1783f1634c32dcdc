"""What .ci/tidy_wheel.py does to a wheel: no folder of this machine stays, and the checksums are true."""

import base64
import hashlib
import subprocess
import sys
import zipfile
from pathlib import Path

import pytest

from tests.support.paths import ROOT

SCRIPT = ROOT / ".ci" / "tidy_wheel.py"
BILL = "x-1.dist-info/sboms/x.cyclonedx.json"
RECORD = "x-1.dist-info/RECORD"

pytestmark = pytest.mark.skipif(not SCRIPT.is_file(), reason="needs the source tree")


def wheel_of(folder, files):
    path = folder / "x-1-py3-none-any.whl"
    with zipfile.ZipFile(path, "w") as archive:
        for name, data in files.items():
            archive.writestr(name, data)
        archive.writestr(RECORD, "".join(f"{name},sha256=old,1\n" for name in files) + f"{RECORD},,\n")
    return path


def run(*arguments):
    return subprocess.run([sys.executable, str(SCRIPT), *map(str, arguments)], capture_output=True, text=True)


def test_the_bill_of_materials_loses_its_folders(tmp_path):
    crate = (ROOT / "rust/antires-core").as_uri()
    bill = f'{{"bom-ref": "path+{crate}#0.1.0", "purl": "pkg:cargo/faer@1"}}'
    wheel = wheel_of(tmp_path, {"x.py": "", BILL: bill})
    assert run("--strict", wheel).returncode == 0
    assert list(tmp_path.iterdir()) == [wheel]
    with zipfile.ZipFile(wheel) as archive:
        assert archive.read(BILL) == b'{"bom-ref": "rust/antires-core#0.1.0", "purl": "pkg:cargo/faer@1"}'
        rows = dict(line.split(",", 1) for line in archive.read(RECORD).decode().splitlines())
        assert rows.pop(RECORD) == ","
        assert set(rows) == {"x.py", BILL}
        for name, row in rows.items():
            digest = base64.urlsafe_b64encode(hashlib.sha256(archive.read(name)).digest()).decode()
            assert row == f"sha256={digest.rstrip('=')},{len(archive.read(name))}"


def test_a_folder_left_inside_is_said_and_with_strict_an_error(tmp_path):
    wheel = wheel_of(tmp_path, {"x.so": b"\0" + str(Path.home() / "secret.rs").encode(), BILL: "{}"})
    for options, code in ((["--strict"], 1), ([], 0)):
        done = run(*options, wheel)
        assert done.returncode == code
        assert f"x.so contains {Path.home()}" in done.stdout


def test_a_wheel_without_a_bill_is_refused(tmp_path):
    done = run(wheel_of(tmp_path, {"x.py": ""}))
    assert done.returncode == 1
    assert "no bill of materials" in done.stderr
