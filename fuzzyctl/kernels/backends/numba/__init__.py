"""The numba backend: source text, machine code, threads and caches."""
