"""The explanation of one evaluation: degrees, activations and implied sets."""
