"""Calibration: fit what the paper does not print to its Table 12."""
