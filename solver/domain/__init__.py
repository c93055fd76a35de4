"""What a map is defined on."""
