"""The scripted visual operator: does the placing task from what the page shows, and moves a hand; no person."""
