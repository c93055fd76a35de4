"""From a drawn outline to a well-shaped triangle mesh."""
