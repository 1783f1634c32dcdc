"""What workers do in the tests: at the top of a module, so that processes find it."""

import os
import signal
import threading
import time
from pathlib import Path

import numpy as np


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
    return threading.Lock()


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


def slow_sphere(x):
    time.sleep(0.05)
    return float(np.sum((x - 0.3) ** 2))


def sphere(x):
    return float(np.sum((x - 0.3) ** 2))


def spheres(candidates):
    return np.sum((candidates - 0.3) ** 2, axis=1)


class Breaks:
    """The sphere, but for evaluations beyond a number, which raise or end their worker."""

    def __init__(self, folder, after, kill=False):
        self.folder, self.after, self.kill = folder, after, kill

    def __call__(self, x):
        count = len(os.listdir(self.folder))
        Path(self.folder, f"{os.getpid()}-{time.monotonic_ns()}").touch()
        if count == self.after:
            if self.kill:
                os.kill(os.getpid(), signal.SIGKILL)
            raise ZeroDivisionError("in f")
        return sphere(x)


def squares_by_two(count):
    from antires_rs.support.workers import in_order

    return list(in_order(square, range(count), 2))
