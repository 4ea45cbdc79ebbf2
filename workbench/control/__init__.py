"""The control law as pure functions: guidance, cascade, allocation, loop points."""
