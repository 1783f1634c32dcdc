"""One door to every kind of worker: this process, threads, processes of our own, an executor, a cluster.

``door.in_order(function, tasks, workers)`` is what rooms call; ``door.Workers`` keeps processes for several
rounds. The results do not depend on the workers: tasks are numbered, answers are put back in order, and a
task whose worker is lost is done again.

- ``door``: what ``workers=`` may be, and results in the order of tasks or as they come
- ``schedule``: chunks of about a second from measured times, what is in flight, what was lost
- ``answers``: what a worker does with a chunk, and what it sends back
- ``engine``: what every kind of worker can do; the first kinds, this process and threads
- ``processes``: processes of our own, one pipe each
- ``executors``: anything with ``submit``; ``dask`` what is different there; ``pools`` of multiprocessing
- ``maps``: anything with ``map`` only
"""
