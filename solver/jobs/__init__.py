"""Job files: their tables, and the files that a job writes."""
