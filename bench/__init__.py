"""Timings as ratios: our way of measuring beside a peer's, in the same run. `python -m bench`."""
