"""Calibration: fit of unpublished values to the paper's Table 12."""
