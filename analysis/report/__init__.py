"""What is told: sentences, page, terminal, JSON, PDF; the last room, nothing computes here."""
