"""Tables 12 and 13 of the paper, as they are printed: RMSE of x_e [m], y_e [m] and theta_e [rad]."""

ROBOTS = ("leader", "follower1", "follower2")
NAMES = ("x_e", "y_e", "theta_e")


def _rows(*rows):
    return {robot: dict(zip(NAMES, row, strict=True)) for robot, row in zip(ROBOTS, rows, strict=True)}


#: Goto, Bertol, Martins, Table 12: with disturbances and obstacles.
TABLE_12 = {
    "smc": _rows((3.2309, 3.4591, 4.0197), (0.8302, 2.3546, 0.4170), (0.7973, 1.9537, 0.4404)),
    "aifqsmc": _rows((0.5399, 0.6988, 0.2327), (0.1298, 0.1340, 0.0318), (0.1008, 0.1114, 0.0206)),
    "fcafsmc": _rows((0.4519, 0.5694, 0.2546), (0.1806, 0.1883, 0.0528), (0.1456, 0.1693, 0.0427)),
}
#: The same, Table 13: in Gazebo, without disturbances.
TABLE_13 = {"aifqsmc": _rows((0.4604, 0.5881, 0.2205), (0.1532, 0.2428, 0.1987), (0.0999, 0.1560, 0.0349))}
