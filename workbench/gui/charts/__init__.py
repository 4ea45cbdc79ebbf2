"""Charts: strips that follow a flight, and plots of what is done."""
