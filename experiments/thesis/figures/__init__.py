"""Figures of the thesis that no room draws by itself, and how a drawing is written."""
