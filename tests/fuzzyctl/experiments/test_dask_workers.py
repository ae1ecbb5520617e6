"""Processes of a dask cluster on this computer."""

import logging

import distributed
import pytest

from fuzzyctl.experiments import dask_workers
from fuzzyctl.experiments.sweep_workers import SweepError


def levels():
    return [handler.level for handler in logging.getLogger("distributed").handlers]


def test_workers_print_no_errors_of_their_own():
    with dask_workers._cluster("local:1") as here, distributed.Client(here, set_as_default=False) as client:
        (found,) = client.run(levels).values()
    assert found == [logging.CRITICAL]


def test_an_address_that_is_none_is_reported():
    with pytest.raises(SweepError, match="no dask scheduler answers at nonsense://x"):
        list(dask_workers.compute(None, [], "nonsense://x"))
