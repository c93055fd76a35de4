"""Plans and modules to start from, as arrays."""
