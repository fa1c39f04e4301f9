"""Short studies to copy, one per method. See `tactometry new --list`."""
