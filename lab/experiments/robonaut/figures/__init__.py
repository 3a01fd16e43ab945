"""The report's figures, as PNG: frames with the model, and curves."""
