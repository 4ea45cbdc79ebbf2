"""Experiments on the flying diagram: steps, their metrics, and the paper's figures."""
