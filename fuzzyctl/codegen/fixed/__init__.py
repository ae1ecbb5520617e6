"""Programs in integers, with a proved bound of their error."""
