"""What a control tick costs."""
