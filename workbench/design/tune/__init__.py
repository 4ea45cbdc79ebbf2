"""From wishes to gains: what is wished, what is searched, what stands against what, the proof."""
