"""What is done to plans: solved, designed, completed, measured, exported."""
