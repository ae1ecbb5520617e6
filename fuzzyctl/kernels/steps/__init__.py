"""Steps of controllers: one function over explicit state."""
