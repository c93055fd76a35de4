"""The Gauss map is the unknown: its boundary conditions, its energy, its minimisers."""
