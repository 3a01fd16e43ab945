"""The command `farhand status` of a running cell: received, put into words, drawn on one screen."""
