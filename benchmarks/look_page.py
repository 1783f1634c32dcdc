"""The page of ``antires look``: how long until there is something to see, and what it looks like.

A record of eight channels (the chain, 256 s at 512 Hz) and its FRFs, in universal files. The clock runs from
the start of the command until the browser has drawn the first figures (curve, coherence, singular values),
and until the values are in the table. The browser runs already, as a user's does. On a busy computer the
seconds that the command itself has computed until the first picture tell more. Needs playwright and Chromium.

    python -m benchmarks.look_page                        # five runs of each
    python -m benchmarks.look_page --pictures DIR         # also at 1400 and 500 pixels, with two edits
"""

from __future__ import annotations

import argparse
import os
import shutil
import statistics
import subprocess
import sys
import tempfile
import time
from pathlib import Path

import antires_rs as ar
from benchmarks.study_tools import print_table

BAND = ("3", "130")
VALUES = "#values tbody td.hz"


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.partition("\n")[0])
    parser.add_argument("--runs", type=int, default=5)
    parser.add_argument("--pictures", type=Path, help="folder for two PNG files")
    args = parser.parse_args()
    from playwright.sync_api import sync_playwright

    with tempfile.TemporaryDirectory() as folder, sync_playwright() as play:
        files = written(Path(folder))
        path = shutil.which("chromium") or shutil.which("google-chrome")
        browser = play.chromium.launch(executable_path=path, args=["--no-sandbox"])
        page = browser.new_page(viewport={"width": 1400, "height": 1000})
        rows = []
        for file in files:
            runs = [timed(page, file) for _ in range(args.runs)]
            first, values, computed = zip(*runs, strict=True)
            middle = [f"{statistics.median(each):.2f}" for each in (first, values, computed)]
            rows.append([file.name, f"{min(first):.2f}", *middle])
        load = os.getloadavg()[0]
        print_table(
            ["file", "first picture, best (s)", "median (s)", "values (s)", "computed (s)"],
            rows,
            markdown=False,
        )
        print(f"{os.cpu_count()} processors, {load:.1f} tasks running")
        if args.pictures is not None:
            args.pictures.mkdir(parents=True, exist_ok=True)
            draw(page, files[0], args.pictures)
        browser.close()


def written(folder: Path) -> list[Path]:
    record = ar.cases.chain8().experiment(level=1, noise=0.01, rng=1)
    return [
        ar.write_uff(folder / "record.uff", record),
        ar.write_uff(folder / "frfs.uff", ar.frf(record, nperseg=2048)),
    ]


def started(file: Path) -> tuple[subprocess.Popen[str], str]:
    call = [sys.executable, "-m", "antires_rs.app.main", "look", str(file), "--no-browser", "--band", *BAND]
    process = subprocess.Popen(
        [*call, "--excitation", "0"], stdout=subprocess.PIPE, text=True, cwd=file.parent
    )
    assert process.stdout is not None
    return process, process.stdout.readline().rpartition(" ")[2].strip()


def timed(page, file: Path) -> tuple[float, float, float]:
    """Seconds until the first picture and until the values, and those computed until the first."""
    begin = time.time()
    process, address = started(file)
    page.goto(address, wait_until="commit")
    page.wait_for_selector("#pictures[data-at]", timeout=120_000)
    computed = _computed_s(process.pid)
    first = float(page.get_attribute("#pictures", "data-at")) / 1e3 - begin
    page.wait_for_selector(VALUES, timeout=120_000)
    values = time.time() - begin
    page.goto("about:blank")
    process.wait(timeout=60)
    return first, values, computed


def _computed_s(process: int) -> float:
    """Processor time of a process, where the system tells it in a file."""
    try:
        fields = Path(f"/proc/{process}/stat").read_text().rpartition(")")[2].split()
    except OSError:
        return float("nan")
    return (int(fields[11]) + int(fields[12])) / os.sysconf("SC_CLK_TCK")


def draw(page, file: Path, folder: Path) -> None:
    """The page with a value dropped and another added, as it stands in the guide."""
    process, address = started(file)
    page.goto(address)
    page.wait_for_selector(VALUES, timeout=120_000)
    page.select_option("#response", "2")
    page.wait_for_selector("#pictures[data-drawn='2']")
    page.fill("#reason", "mains hum")
    page.locator("#values tr[data-dof='2'] td.drop button").nth(1).click()
    page.wait_for_selector("#edits li:nth-child(1)")
    page.fill("#reason", "clear in the phase")
    page.fill("#value", "82.4")
    page.press("#value", "Enter")
    page.wait_for_selector("#edits li:nth-child(2)")
    for width, whole in ((1400, False), (500, True)):
        page.set_viewport_size({"width": width, "height": 1000})
        page.wait_for_timeout(1500)
        picture = folder / f"look_{width}.png"
        page.screenshot(path=picture, full_page=whole)
        _slim(picture)
    page.once("dialog", lambda asked: asked.accept())
    page.goto("about:blank")
    process.wait(timeout=60)


def _slim(picture: Path) -> None:
    from PIL import Image

    Image.open(picture).convert("RGB").quantize(128, dither=Image.Dither.NONE).save(picture, optimize=True)


if __name__ == "__main__":
    main()
