"""The hand as a jointed body of capsules, fitted to its outlines."""
