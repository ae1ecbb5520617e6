"""What tests of drawn systems share."""

import pytest


@pytest.fixture(scope="module")
def kernel_folder(tmp_path_factory):
    """Keep the kernels of drawn systems out of the user's cache."""
    with pytest.MonkeyPatch.context() as patch:
        patch.setenv("FUZZYCTL_CACHE_DIR", str(tmp_path_factory.mktemp("cache")))
        yield
