"""What the report's figures show, as PNG: frames with the model, and curves."""
