"""Step-response regressions: what a spec demands of flights, and whether it holds."""
