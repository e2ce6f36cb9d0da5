"""What examples share: none imports another one."""
