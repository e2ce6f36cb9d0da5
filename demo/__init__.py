"""Drives gear pair FMUs made by gearmesh and repeats the paper's simulations with them."""
