"""The bar that is always there: what flies, how it does, and what can be asked of it."""
