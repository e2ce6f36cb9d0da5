"""One scenario through many hosts: `python -m examples.hosts`."""
