"""Drivelines that copy-and-change users can start from; each folder has a README and runs by `python -m`."""
