"""`python -m dwmr.ros`: the node."""

from dwmr.ros.main import run
from fuzzyctl.ros.program import main

main("formation", run)
