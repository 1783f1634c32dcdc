"""A run on a Dask cluster whose scheduler is killed, and begun anew at its address or not: what comes of it.

python -m tests.support.dask_scheduler restarted|gone
"""

import os
import socket
import subprocess
import sys
import threading
import time

from antires_rs.support.workers import in_order

TASKS = 30


def slow_square(n):
    time.sleep(0.1)
    return n * n


def begun(what, *arguments):
    command = [sys.executable, "-m", f"distributed.cli.dask_{what}", *arguments, "--no-dashboard"]
    quiet = subprocess.DEVNULL
    return subprocess.Popen([*command, "--host", "127.0.0.1"], stdout=quiet, stderr=quiet)


def main(restarted):
    from distributed import Client

    from tests.support import dask_scheduler as named  # by its module, as workers find it

    with socket.socket() as free:
        free.bind(("127.0.0.1", 0))
        port = str(free.getsockname()[1])
    address = f"tcp://127.0.0.1:{port}"
    processes = [begun("scheduler", "--port", port), begun("worker", address, "--nthreads", "1")]
    client = Client(address, timeout=20)
    client.wait_for_workers(1, timeout=60)
    client._timeout = 20 if restarted else 3  # for so long a client tries to connect anew
    some = threading.Event()

    def kill():
        some.wait()
        processes[0].kill()
        processes[0].wait()
        if restarted:
            processes[:2] = [begun("scheduler", "--port", port), processes[1]]
            processes.append(begun("worker", address, "--nthreads", "1"))

    killer = threading.Thread(target=kill)
    killer.start()
    found = []
    try:
        for value in in_order(named.slow_square, range(TASKS), client, seconds_a_chunk=0.2):
            found.append(value)
            if len(found) == 5:
                some.set()
        print("all right" if found == [n * n for n in range(TASKS)] else found, flush=True)
    except Exception as error:
        print(f"{type(error).__name__}: {error}", flush=True)
    killer.join()
    for process in processes:
        process.kill()
    os._exit(0)  # the client has threads that wait for its scheduler


if __name__ == "__main__":
    main(sys.argv[1] == "restarted")
