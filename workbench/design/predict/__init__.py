"""How well a model predicts a flown flight, and how that would have gone with other gains."""
