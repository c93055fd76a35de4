"""Plans as they come from a user, and what is done over them: shells, fits, closings, completions."""
