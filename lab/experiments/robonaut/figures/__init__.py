"""The report's figures, as PNG: frames with the model, curves, the humanoid's postures."""
