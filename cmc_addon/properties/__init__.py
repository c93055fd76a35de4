"""What the add-on keeps in a .blend file, and its settings."""
