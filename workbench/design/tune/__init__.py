"""From wishes to gains: wishes, search, conflicts and proof."""
