"""What workers do in the tests: at the top of a module, so that processes find it."""

import os
import signal
import time
from pathlib import Path


def square(x):
    return x * x


def scaled(factor, x):
    return factor * x


def nap(x):
    time.sleep(0.02)
    return x


def long_nap(x):
    time.sleep(30.0)
    return x


def fails_at_seven(x):
    if x == 7:
        raise ZeroDivisionError("seven")
    return x


def does_not_travel(x):
    return lambda: x


def kills(task):
    """Number ``x``; number 5 takes its worker along as often as it is told, which the folder counts."""
    folder, x, times = task
    if x == 5:
        count = len(os.listdir(folder))
        if count < times:
            Path(folder, str(count)).touch()
            os.kill(os.getpid(), signal.SIGKILL)
    return x


def worker(_):
    time.sleep(0.05)
    return os.getpid()
