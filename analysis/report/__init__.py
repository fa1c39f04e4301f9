"""Report of an analysis: sentences, page, terminal, JSON, PDF."""
