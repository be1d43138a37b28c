"""For all tests: how hypothesis draws, and what the markers say."""
import subprocess
import sys
from pathlib import Path

import pytest
from hypothesis import settings

from tests.stale_code import remove_stale_code

TESTS = Path(__file__).parent
BLENDER = {"addon", "demo"}  # folders whose tests need Blender's module
SLOW = {"benchmarks"}  # folders whose tests compile codecs of their own

# No deadline: a first call loads compiled code, or compiles it, and a machine may be busy. The same examples in every
# run: what turns red is the change at hand. New ones on demand: pytest --hypothesis-profile=search
settings.register_profile("repeat", deadline=None, derandomize=True, print_blob=True)
settings.register_profile("search", deadline=None, print_blob=True)
settings.load_profile("repeat")


def pytest_configure(config):
    """Once a run, before anything is compiled or found compiled."""
    if not hasattr(config, "workerinput"):  # of pytest-xdist's processes
        remove_stale_code()


def pytest_collection_modifyitems(items):
    """Mark what needs Blender and what is slow by its folder, and what needs torch by what its module imports."""
    for item in items:
        folder = item.path.relative_to(TESTS).parts[0]
        if folder in BLENDER:
            item.add_marker(pytest.mark.blender)
        if folder in SLOW:
            item.add_marker(pytest.mark.slow)
        if hasattr(item.module, "torch"):
            item.add_marker(pytest.mark.torch)


@pytest.hookimpl(optionalhook=True)  # of pytest-xdist
def pytest_xdist_setupnodes():
    """Compile, or find compiled, what most tests call, before several processes start that would do so at the same time.

    They would do it twice, and numba may mix up two signatures of a function that two processes compile at once.
    """
    subprocess.run([sys.executable, "-m", "tests.compile_all"], cwd=TESTS.parent, check=True)
