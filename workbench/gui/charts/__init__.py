"""Charts: strip charts that follow a flight, and plots of finished data."""
