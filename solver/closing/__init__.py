"""Closing: the periods that must vanish for a surface to close, and the steps that make them vanish."""
