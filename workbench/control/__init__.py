"""The control law as pure functions: guidance, the law, allocation, loop points."""
