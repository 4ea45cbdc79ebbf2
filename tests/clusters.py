"""A Dask cluster of this machine, as one of several machines is reached: over TCP."""

from distributed import LocalCluster


def local_cluster(workers: int) -> LocalCluster:
    """Return a cluster with so many workers, each a process with a thread."""
    return LocalCluster(
        n_workers=workers,
        threads_per_worker=1,
        processes=True,
        protocol="tcp://",
        host="127.0.0.1",
        dashboard_address="127.0.0.1:0",
    )
