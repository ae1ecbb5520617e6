"""Processes of a dask cluster on this computer."""

import logging

import distributed
import pytest

from fuzzyctl.experiments.sweep import cluster
from fuzzyctl.experiments.sweep.worker import SweepError


def levels():
    return [handler.level for handler in logging.getLogger("distributed").handlers]


def test_workers_print_no_errors_of_their_own():
    with cluster._cluster("local:1") as here, distributed.Client(here, set_as_default=False) as client:
        (found,) = client.run(levels).values()
    assert found == [logging.CRITICAL]


def test_an_address_that_is_none_is_reported():
    with pytest.raises(SweepError, match="no dask scheduler answers at nonsense://x"):
        list(cluster.compute(None, [], "nonsense://x"))
