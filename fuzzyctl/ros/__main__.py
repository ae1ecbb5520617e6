"""`python -m fuzzyctl.ros`: the node."""

from fuzzyctl.ros.controller import run
from fuzzyctl.ros.program import main

main("controller", run)
