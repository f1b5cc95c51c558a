"""A filter that learned its dials: features, filter layer, model, training (chapter 09)."""
