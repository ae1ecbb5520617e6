"""Many runs of one scenario: what varies, who computes it, what is kept."""
