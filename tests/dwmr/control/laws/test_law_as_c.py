"""The law as C against the record of a run: each robot's controller, fed with what the robot saw, gives its commands.

`python -m pytest -n 0 -m "long or not long" tests/dwmr/control/laws/test_law_as_c.py` compares the whole run of 200 s.
"""

import shutil
import subprocess

import numpy as np
import pytest

from dwmr.control.formation import follower_error, trajectory_error
from fuzzyctl.testing import run_command
from tests.shipped import rules_folder

pytestmark = pytest.mark.skipif(shutil.which("gcc") is None, reason="gcc is not installed")

#: Reads rows of inputs, and writes the commands and k̂_h of both channels.
DRIVER = r"""
#include <stdio.h>
#include "aifqsmc.h"

int main(void)
{
    aifqsmc_state state;
    aifqsmc_outputs o;
    double x[8];
    aifqsmc_init(&state);
    while (fread(x, sizeof(double), 8, stdin) == 8) {
        aifqsmc_step(&state, x[0], x[1], x[2], x[3], x[4], x[5], x[6], x[7], &o);
        double y[4] = {o.v_c, o.omega_c, o.k_h_v, o.k_h_omega};
        fwrite(y, sizeof(double), 4, stdout);
    }
    return 0;
}
"""


@pytest.fixture(scope="module")
def law(tmp_path_factory):
    """A function from inputs, shape (samples, 8), to commands and gains, shape (samples, 4), computed in C."""
    folder = tmp_path_factory.mktemp("law")
    done = run_command("codegen", rules_folder() / "aifqsmc.fz", "--target", "c", "-o", folder)
    assert done.exit_code == 0, done.output
    (folder / "driver.c").write_text(DRIVER, encoding="utf-8")
    subprocess.run(
        ["gcc", "-std=c99", "-O2", "-Wall", "-Wextra", "-Werror", "driver.c", "aifqsmc.c", "-lm", "-o", "driver"],
        cwd=folder, check=True,
    )  # fmt: skip

    def run(inputs):
        done = subprocess.run([folder / "driver"], input=inputs.tobytes(), capture_output=True, check=True)
        return np.frombuffer(done.stdout).reshape(-1, 4)

    return run


def errors(file, trajectory, robot):
    """Return what a robot saw at each sample, from the record alone, shape (samples, 7)."""
    settings = file.scenario.robots[robot]
    names, values = trajectory.robots, {s: trajectory[s] for s in trajectory.names[:20]}
    i = names.index(robot)
    rows = []
    for k in range(len(trajectory.t)):
        now = {s: float(v[k, i]) for s, v in values.items()}
        pose = now["x"], now["y"], now["theta"]
        if settings.formation is None:
            target = now["x_r"], now["y_r"], now["theta_r"], now["theta_r_star"], now["v_r"], settings.d
            rows.append(trajectory_error(*pose, *target))
        else:
            j, formation = names.index(settings.formation.leader), settings.formation
            lead = {s: float(v[k, j]) for s, v in values.items()}
            rows.append(
                follower_error(
                    lead["x"], lead["y"], lead["theta"], lead["v"] + lead["d_v"], lead["omega"] + lead["d_omega"],
                    file.scenario.robots[settings.formation.leader].d, *pose, now["theta_r_star"], settings.d,
                    formation.separation, formation.bearing,
                )
            )  # fmt: skip
    return np.array(rows)


@pytest.mark.parametrize("horizon", [5, pytest.param(200, marks=pytest.mark.long)])
def test_the_law_as_c_gives_what_the_run_recorded(run_paper, law, horizon):
    file, trajectory = run_paper("aifqsmc", f"run.horizon={horizon}")
    for i, robot in enumerate(trajectory.robots):
        seen = errors(file, trajectory, robot)
        assert seen[:, :2] == pytest.approx(np.column_stack([trajectory["x_e"][:, i], trajectory["y_e"][:, i]]))
        found = law(np.column_stack([seen, np.full(len(seen), file.scenario.run.dt)]))
        recorded = np.column_stack([trajectory[s][:, i] for s in ("v_c", "omega_c", "k_h_v", "k_h_omega")])
        assert np.abs(found - recorded).max() <= 1e-9
