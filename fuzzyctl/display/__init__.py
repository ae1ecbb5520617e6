"""Systems, blocks, kernels, runs, traces and verdicts as text and as HTML."""
