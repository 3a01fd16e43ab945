"""Stand-ins around real sites: a scripted operator, a page without a browser, cameras that play rendered views."""
