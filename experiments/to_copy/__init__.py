"""Studies to copy: one method each, as short as it can be. `tactometry new --list` names them."""
