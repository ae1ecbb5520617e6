"""Programs as source text for machines without Python: C99, Structured Text, fixed point, plain Python."""
