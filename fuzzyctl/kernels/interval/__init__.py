"""Interval arithmetic with outward rounding, for scalars and for arrays."""
