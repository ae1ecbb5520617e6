"""The command in a process of its own, as a user runs it."""

import contextlib
import os
import subprocess
import sys

from click.testing import CliRunner

from dwmr.cli.main import main
from tests import sizes

#: Seconds after which a command counts as one that never ends: many times what it takes on the busiest machine.
LONG = 600


def words(*arguments):
    """What the command line is made of; a warning ends it."""
    return [sys.executable, "-W", "error", "-m", "dwmr", *map(str, arguments)]


def dwmr(*arguments, status=0, stdout=subprocess.PIPE, cwd=None, timeout=LONG, start_new_session=False, **environment):
    """Run the command; neither stream may show a traceback.

    Args:
        arguments: What stands behind `dwmr`.
        status: The expected exit code.
        stdout: Where standard output goes.
        cwd: The folder it runs in.
        timeout: Seconds.
        start_new_session: Whether it gets signals of a terminal of its own.
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
        start_new_session=start_new_session,
        env={**os.environ, **environment},
    )
    shown = done.stderr + (done.stdout or "")
    assert "Traceback" not in shown, shown
    assert done.returncode == status, done.stderr
    return done


def here(*arguments, status=0, cwd=".", **environment):
    """Run the command within this process, where a test is not about processes: a new one spends a second on imports.

    Args:
        arguments: What stands behind `dwmr`.
        status: The expected exit code.
        cwd: The folder it runs in.
        environment: Variables besides those of this process.
    """
    with contextlib.chdir(cwd):
        done = CliRunner(env=environment).invoke(main, list(map(str, arguments)), prog_name="dwmr")
    if done.exception is not None and not isinstance(done.exception, SystemExit):
        raise done.exception
    assert done.exit_code == status, done.stderr
    return subprocess.CompletedProcess(arguments, done.exit_code, done.stdout, done.stderr)


def in_short(*arguments, **options):
    """Run the command as `here` does in the test line, and as `dwmr` does before a release."""
    return (dwmr if sizes.LONG else here)(*arguments, **options)


#: What Python runs when it starts: the first worker interrupts the whole group, as Ctrl-C does.
INTERRUPTS = """
import os, signal, sys
if "--multiprocessing-fork" in sys.orig_argv:
    try:
        os.close(os.open(os.environ["INTERRUPTED"], os.O_CREAT | os.O_EXCL))
    except FileExistsError:
        pass
    else:
        os.killpg(0, signal.SIGINT)
"""


def interrupted_by_a_worker_that_starts(folder, *arguments):
    """Run the command, and send Ctrl-C to all its processes when the first worker starts, before it runs any own code.

    Args:
        folder: For the file that does so.
        arguments: What stands behind `dwmr`.
    """
    (folder / "sitecustomize.py").write_text(INTERRUPTS, encoding="utf-8")
    environment = {"PYTHONPATH": str(folder), "INTERRUPTED": str(folder / "interrupted")}
    return dwmr(*arguments, status=130, start_new_session=True, **environment)
