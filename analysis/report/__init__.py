"""Report of an analysis as HTML page, terminal output, JSON and PDF."""
