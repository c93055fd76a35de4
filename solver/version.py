"""The version of the program, for reports and both command lines."""

__version__ = "0.1.0"
PROGRAM = f"cmc-formfinding {__version__}"
