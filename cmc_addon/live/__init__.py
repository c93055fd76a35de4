"""Live: the shell follows while its plan or its settings change."""
