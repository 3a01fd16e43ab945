"""What `farhand status` shows of a running cell: received, put into words, drawn on one screen."""
