"""Systems built by Python calls."""
