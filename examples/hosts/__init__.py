"""One scenario through many hosts: `python -m examples.hosts` writes docs/hosts.md."""
