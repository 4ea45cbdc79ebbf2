"""The gains that are being tuned: the model, and the form that shows it."""
