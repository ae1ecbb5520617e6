"""The command in a process of its own, as a user runs it."""

import os
import subprocess
import sys


def words(*arguments):
    """What the command line is made of; a warning ends it."""
    return [sys.executable, "-W", "error", "-m", "dwmr", *map(str, arguments)]


def dwmr(*arguments, status=0, stdout=subprocess.PIPE, cwd=None, timeout=300, **environment):
    """Run the command; neither stream may show a traceback.

    Args:
        arguments: What stands behind `dwmr`.
        status: The exit code that is due.
        stdout: Where standard output goes.
        cwd: The folder it runs in.
        timeout: Seconds.
        environment: Variables besides those of this process.
    """
    done = subprocess.run(
        words(*arguments),
        stdout=stdout,
        stderr=subprocess.PIPE,
        text=True,
        timeout=timeout,
        check=False,
        cwd=cwd,
        env={**os.environ, **environment},
    )
    assert "Traceback" not in done.stderr + (done.stdout or "")
    assert done.returncode == status, done.stderr
    return done
