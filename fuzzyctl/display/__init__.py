"""What systems, blocks, kernels, runs, traces and verdicts look like as text and as HTML."""
