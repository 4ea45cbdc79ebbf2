"""Experiments on the diagram that flies: steps, their metrics, and the paper's figures."""
