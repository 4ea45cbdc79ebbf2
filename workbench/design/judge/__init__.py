"""The judgement of every loop of the closed loop that flies."""
