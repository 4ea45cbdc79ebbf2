"""A cluster of two processes, and tasks that other processes find by their module's name."""

import sys
from pathlib import Path

import pytest

sys.path.append(str(Path(__file__).parent))


@pytest.fixture(scope="session")
def started_workers():
    """Return a Dask cluster with two workers, each a process that is reached over TCP."""
    from tests.clusters import local_cluster

    with local_cluster(2) as cluster:
        yield cluster


@pytest.fixture
def workers(started_workers):
    """Return the cluster with both its workers: one that was killed is started again."""
    started_workers.wait_for_workers(2)
    return started_workers


@pytest.fixture
def cluster(workers):
    from workbench.design.executor.cluster import DaskCluster

    with DaskCluster(workers.scheduler_address) as executor:
        yield executor
