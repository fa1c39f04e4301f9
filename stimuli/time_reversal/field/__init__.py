"""What a drive does: field, figures of merit, energy, sound, evenness."""
