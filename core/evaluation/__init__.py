"""What an embedding tells: variability and coverage."""
