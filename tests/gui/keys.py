"""Blender's names of the keys that letters are typed with."""

NAMES = {"0": "ZERO", "1": "ONE", "2": "TWO", "3": "THREE", "4": "FOUR", "5": "FIVE", "6": "SIX", "7": "SEVEN",
         "8": "EIGHT", "9": "NINE", ".": "PERIOD", " ": "SPACE", "-": "MINUS"}


def name(letter: str) -> str:
    return NAMES.get(letter, letter.upper())
