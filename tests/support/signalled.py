"""Runs of ``antires`` that get a signal during their search."""

import dataclasses
import subprocess
import sys
import time

from antires_rs.app import arguments
from tests.support.job_files import UPDATE

LONG = UPDATE.replace(  #: Some two hundred generations with migrations, a second or two.
    "seed = 1",
    "seed = 3\nmax_evaluations = 60_000\npatience = 5\n"
    "improvement_tolerance = 0.02\npolish = false\nworkers = 1",
)

ANTIRES = """
import sys
from antires_rs.app.main import main
sys.exit(main(sys.argv[1:]))
"""


def _holds(record, text):
    """Whether the record of a run holds the text; a run takes that of the run before away."""
    try:
        return text in record.read_text()
    except FileNotFoundError:
        return False


def stopped(folder, how, *call, after=0.3, until="searching", code=ANTIRES):
    """Exit code, output, errors and seconds of an ``antires`` that got a signal during its search."""
    pipe = subprocess.PIPE
    call = [sys.executable, "-c", code, *call]
    with subprocess.Popen(call, stdout=pipe, stderr=pipe, text=True, cwd=folder) as process:
        try:
            record = folder / "job_results" / "run.json"
            deadline = time.monotonic() + 60.0
            while not _holds(record, until):
                assert process.poll() is None, process.stderr.read()
                assert time.monotonic() < deadline
                time.sleep(0.005)
            time.sleep(after)
            start = time.monotonic()
            process.send_signal(how)
            out, err = process.communicate(timeout=30)
            return process.returncode, out, err, time.monotonic() - start
        finally:
            process.kill()


def interrupt_assessments(patch):
    """From here on assessments of jobs end as if Ctrl-C had come."""
    complete = arguments.assess_damage

    def interrupted(*args, **options):
        result = complete(*args, **options)
        search = dataclasses.replace(result.search, status="interrupted", success=False)
        judged = (result.assessment,) if "baseline" in options else ()
        return type(result)(result.problem, search, result.seed, *judged)

    patch.setattr(arguments, "assess_damage", interrupted)
