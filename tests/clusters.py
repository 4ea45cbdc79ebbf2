"""A Dask cluster of this machine, as one of several machines is reached: over TCP."""

from typing import Any


def local_cluster(workers: int) -> Any:
    """Return a `LocalCluster` with so many workers, each a process with a thread."""
    from distributed import LocalCluster  # slow to load, and only slow tests have a cluster

    return LocalCluster(
        n_workers=workers,
        threads_per_worker=1,
        processes=True,
        protocol="tcp://",
        host="127.0.0.1",
        dashboard_address="127.0.0.1:0",
    )
