"""The meaning of a rule file: frozen types without text and without numerics of inference."""
