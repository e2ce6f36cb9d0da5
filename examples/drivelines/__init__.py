"""Drivelines to copy and change; each folder runs by `python -m`, and docs/drivelines.md shows what it finds."""
