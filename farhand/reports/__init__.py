"""Reports for people: a page of HTML with tables and pictures, and plots."""
