"""Read what drives the joints of a description, a file for each way to say it."""
