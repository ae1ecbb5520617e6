"""`python -m dwmr.ros`: the node."""

from dwmr.ros.main import main

main()
