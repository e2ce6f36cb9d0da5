"""`make release`: what a user downloads, for linux64 and win64, in target/dist."""
