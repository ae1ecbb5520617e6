"""The robots and their surroundings: dynamics, bodies, disturbances and obstacles."""
