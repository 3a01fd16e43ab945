"""The operator's side: cameras, tracking, gestures, and a simulated operator."""
